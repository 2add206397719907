#include "notify/webhook_message.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/stat.h>

#include <array>
#include <fstream>
#include <iterator>
#include <new>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "wire/enum_words.h"

namespace tessera::server {

std::string end_message(const v1::JobStatus& status) {
  const google::protobuf::Duration& cpu = status.stats().cpu_time();
  const nlohmann::ordered_json message = {
      {"event", "job.ended"},
      {"job", status.job_id()},
      {"name", status.name()},
      {"comment", status.comment()},
      {"user", status.user()},
      {"state", wire::word_of(status.state())},
      {"error", status.error()},
      {"units_done", status.units_done()},
      {"units_total", status.units_total()},
      {"units_set_aside", status.units_set_aside()},
      {"cpu_seconds", static_cast<double>(cpu.seconds()) + 1e-9 * cpu.nanos()},
      {"submitted_unix_ms", status.submitted_unix_ms()},
      {"finished_unix_ms", status.finished_unix_ms()}};
  return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string signature_of(const std::string& key, std::int64_t unix_seconds, const std::string& body) {
  const std::string text = absl::StrCat(unix_seconds, ".", body);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  if (HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
           reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data(), &size) == nullptr)
    throw std::bad_alloc();
  return absl::StrCat(
      "v1=", absl::BytesToHexString(std::string(reinterpret_cast<const char*>(digest.data()), size)));
}

absl::StatusOr<std::string> read_webhook_key(const std::string& file) {
  constexpr std::size_t kLeastBytes = 16;
  struct stat about {};
  std::ifstream in(file, std::ios::binary);
  if (!in || stat(file.c_str(), &about) != 0)
    return absl::InvalidArgumentError(absl::StrCat("--webhook-key: ", file, " cannot be read"));
  if ((about.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("--webhook-key: others may read ", file, " (chmod 600 ", file, ")"));
  }
  std::string key{std::istreambuf_iterator<char>(in), {}};
  // An editor's or openssl's end of line; other bytes that happen to be white space are the key's.
  if (key.ends_with('\n')) key.pop_back();
  if (key.size() >= kLeastBytes) return key;
  return absl::InvalidArgumentError(absl::StrCat("--webhook-key: ", file, " has ", key.size(), " bytes; ",
                                                 kLeastBytes,
                                                 " or more were expected, as of: openssl rand -hex 32"));
}

}  // namespace tessera::server
