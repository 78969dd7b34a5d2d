// What every command that talks to a service opens first: a client, and the way to the user.
#pragma once

#include <absl/status/statusor.h>
#include <google/protobuf/message.h>

#include <memory>
#include <optional>
#include <string>

#include "client/client.h"
#include "client/commands.h"
#include "client/private_folder.h"
#include "client/progress.h"

namespace halfshade {

class Session {
 public:
  // Usage errors for a server that is not HOST:PORT or unix:PATH; else Client::Connect's. Call before any thread is
  // started.
  static absl::StatusOr<std::unique_ptr<Session>> Open(const GlobalFlags& global);
  // Of many calls at a time: --timeout is that of each, and none shows its own progress.
  static absl::StatusOr<std::unique_ptr<Session>> OpenForMany(const GlobalFlags& global);

  Client& client() { return *client_; }
  Progress& progress() { return progress_; }

 private:
  Session() = default;
  static absl::StatusOr<std::unique_ptr<Session>> Open(const GlobalFlags& global, bool is_for_many);
  absl::Status PrepareInProcess(const GlobalFlags& global, ServerOptions* options);

  std::optional<PrivateFolder> store_;  // outlives the service
  Progress progress_;
  std::unique_ptr<Client> client_;
};

// Proto3 JSON, indented; with every default where `with_defaults`.
std::string ToJson(const google::protobuf::Message& message, bool with_defaults);

// To stdout, all of it; exit code 74 where that fails.
absl::Status Print(const std::string& text);

}  // namespace halfshade
