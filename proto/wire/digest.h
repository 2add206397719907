// SHA-256 digests as names of blobs.
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace tessera::wire {

/// SHA-256 of `bytes` as 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

/// True for 64 lower-case hexadecimal digits: safe to use as a file name.
bool is_digest(std::string_view text);

/// SHA-256 of bytes that come in pieces.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::string_view bytes);
  /// The digest of all bytes so far; the object starts anew.
  std::string finish_hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace tessera::wire
