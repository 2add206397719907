#include "wire/digest.h"

#include <openssl/evp.h>

#include <algorithm>
#include <new>

namespace tessera::wire {
namespace {

constexpr std::size_t kSha256Bytes = 32;

// OpenSSL fails here only when it has no memory or no SHA-256 at all; neither leaves anything to go on with.
void require(int result) {
  if (result != 1) throw std::bad_alloc();
}

}  // namespace

struct Sha256::Context {
  EVP_MD_CTX* evp = EVP_MD_CTX_new();

  Context() {
    require(evp != nullptr);
    require(EVP_DigestInit_ex(evp, EVP_sha256(), nullptr));
  }
  ~Context() { EVP_MD_CTX_free(evp); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::update(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->evp, bytes.data(), bytes.size()));
}

std::string Sha256::finish_hex() {
  unsigned char raw[kSha256Bytes];
  require(EVP_DigestFinal_ex(context_->evp, raw, nullptr));
  require(EVP_DigestInit_ex(context_->evp, EVP_sha256(), nullptr));
  std::string hex;
  hex.reserve(2 * kSha256Bytes);
  for (const unsigned char byte : raw) {
    hex.push_back("0123456789abcdef"[byte >> 4]);
    hex.push_back("0123456789abcdef"[byte & 15]);
  }
  return hex;
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 sha;
  sha.update(bytes);
  return sha.finish_hex();
}

bool is_digest(std::string_view text) {
  return text.size() == 2 * kSha256Bytes && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

}  // namespace tessera::wire
