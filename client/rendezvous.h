// Which of several servers keeps a scene: rendezvous hashing, so that a server more or less moves only its own scenes.
#pragma once

#include <string>
#include <vector>

namespace halfshade {

// `servers`, best first, by SHA-256("<server>\n<key>"): the same for every client, build and order of the list.
std::vector<std::string> RendezvousOrder(std::vector<std::string> servers, const std::string& key);

}  // namespace halfshade
