// What the commands share: the way to a client and the way to stdout.
#pragma once

#include <absl/status/statusor.h>
#include <google/protobuf/message.h>

#include <memory>
#include <string>

#include "client/client.h"
#include "client/commands.h"
#include "client/progress.h"

namespace halfshade {

// Usage errors for a server that is not HOST:PORT or unix:PATH; else Client::Connect's.
absl::StatusOr<std::unique_ptr<Client>> ConnectClient(const GlobalFlags& global, Progress* progress);

// Proto3 JSON, indented; with every default where `with_defaults`.
std::string ToJson(const google::protobuf::Message& message, bool with_defaults);

// To stdout, all of it; exit code 74 where that fails.
absl::Status Print(const std::string& text);

}  // namespace halfshade
