// SHA-256 by OpenSSL.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace halfshade {

// 64 lower-case hex digits.
std::string Sha256Hex(const void* data, size_t size);
std::string Sha256Hex(const std::string& bytes);

// Of bytes that come in pieces.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  void Add(const void* data, size_t size);
  // Ends the digest: call once.
  std::string FinishHex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// 64 digits of 0-9a-f.
bool IsSha256Hex(const std::string& text);

}  // namespace halfshade
