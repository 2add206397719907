#include "service/farm/lease_seal.h"

#include <openssl/crypto.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <array>
#include <fstream>
#include <iterator>
#include <new>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "base/private_file.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

/// The fields of a token and the host, each of a length that it says itself: no two grants give the same
/// bytes.
std::string message_of(const v1::LeaseToken& token, std::string_view host) {
  return absl::StrCat("lease ", token.job_id().size(), ":", token.job_id(), " ", token.generation(), " ",
                      token.unit_index(), " ", token.ranges(), " ", token.attempt(), " ", token.epoch(), " ",
                      token.inputs(), token.spot() == 0 ? "" : absl::StrCat(" spot ", token.spot()), " ",
                      std::string(host));
}

}  // namespace

absl::StatusOr<std::shared_ptr<const LeaseSeal>> LeaseSeal::open(const std::filesystem::path& file) {
  if (!file.empty() && std::filesystem::exists(file)) {
    std::ifstream in{file};
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in) return absl::UnavailableError(absl::StrCat(file.string(), " cannot be read"));
    if (text.size() != 2 * kKeyBytes + 1 || text.back() != '\n' ||
        !wire::is_digest(text.substr(0, 2 * kKeyBytes))) {
      return absl::DataLossError(
          absl::StrCat(file.string(),
                       " holds no key. Delete it: a new one is made, and results that workers hold at "
                       "this moment are rendered again"));
    }
    return with_key(absl::HexStringToBytes(text.substr(0, 2 * kKeyBytes)));
  }
  std::string key(kKeyBytes, '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(key.data()), static_cast<int>(key.size())) != 1) {
    return absl::UnavailableError("OpenSSL has no random numbers");
  }
  if (!file.empty()) {
    const std::string text = absl::StrCat(absl::BytesToHexString(key), "\n");
    if (absl::Status status = base::replace_file(file, 0600, text); !status.ok()) return status;
  }
  return with_key(std::move(key));
}

std::shared_ptr<const LeaseSeal> LeaseSeal::with_key(std::string key) {
  return std::shared_ptr<const LeaseSeal>(new LeaseSeal(std::move(key)));
}

std::string LeaseSeal::hmac(std::string_view message) const {
  std::array<unsigned char, 32> digest;
  unsigned int size = 0;
  const unsigned char* const made =
      HMAC(EVP_sha256(), key_.data(), static_cast<int>(key_.size()),
           reinterpret_cast<const unsigned char*>(message.data()), message.size(), digest.data(), &size);
  if (made == nullptr) throw std::bad_alloc();  // OpenSSL fails here only when it has no memory
  return {reinterpret_cast<const char*>(digest.data()), size};
}

void LeaseSeal::seal(v1::LeaseToken& token, std::string_view host) const {
  token.set_seal(hmac(message_of(token, host)).substr(0, kSealBytes));
}

bool LeaseSeal::is_sealed(const v1::LeaseToken& token, std::string_view host) const {
  return token.seal().size() == kSealBytes &&
         CRYPTO_memcmp(token.seal().data(), hmac(message_of(token, host)).data(), kSealBytes) == 0;
}

std::string LeaseSeal::derive_key(std::string_view purpose) const {
  return hmac(absl::StrCat("key ", std::string(purpose)));
}

}  // namespace tessera::server
