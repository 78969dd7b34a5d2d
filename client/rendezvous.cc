#include "client/rendezvous.h"

#include <algorithm>

#include "server/digest.h"

namespace halfshade {

std::vector<std::string> RendezvousOrder(std::vector<std::string> servers, const std::string& key) {
  std::sort(servers.begin(), servers.end(), [&](const std::string& a, const std::string& b) {
    return Sha256Hex(a + "\n" + key) > Sha256Hex(b + "\n" + key);
  });
  return servers;
}

}  // namespace halfshade
