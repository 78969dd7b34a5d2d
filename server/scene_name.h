// A scene's name is its content.
#pragma once

#include <map>
#include <string>

namespace halfshade {

// Between a scene's name and what tells its poses apart, in the names of what is kept of them.
inline constexpr char kPoseSeparator = '@';

// "<root digest>\n" and "<digest> <uri>\n" for each file, sorted by the URI's bytes. files: relative URI -> digest.
std::string SceneManifest(const std::string& root_digest, const std::map<std::string, std::string>& files);

// The way back. False for a text that SceneManifest did not make.
bool ParseSceneManifest(const std::string& manifest, std::string* root_digest,
                        std::map<std::string, std::string>* files);

// "scenes/" + hex SHA-256 of the manifest.
std::string SceneName(const std::string& root_digest, const std::map<std::string, std::string>& files);

// "scenes/" and 64 lower-case hex digits.
bool IsSceneName(const std::string& name);

}  // namespace halfshade
