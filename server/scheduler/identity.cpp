#include "scheduler/identity.h"

#include <algorithm>

namespace tessera::server {
namespace {

struct Parts {
  std::string_view name, fingerprint;  // either may be empty
};

bool is_fingerprint(std::string_view text) {
  return text.size() == kFingerprintDigits && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

/// A host's name may have an "@" itself.
Parts parts_of(std::string_view subject) {
  if (is_fingerprint(subject)) return {.name = {}, .fingerprint = subject};
  const std::size_t at = subject.rfind('@');
  if (at == std::string_view::npos || !is_fingerprint(subject.substr(at + 1)))
    return {.name = subject, .fingerprint = {}};
  return {.name = subject.substr(0, at), .fingerprint = subject.substr(at + 1)};
}

}  // namespace

std::string host_named(const std::string& name, const std::string& fingerprint) {
  return fingerprint.empty() ? name : name + "@" + fingerprint;
}

std::string identity_of(const std::string& host) {
  const Parts parts = parts_of(host);
  return parts.fingerprint.empty() ? host : std::string(parts.fingerprint);
}

bool covers(const std::string& subject, const std::string& host) {
  return subject == host || subject == identity_of(host);
}

std::string short_name(const std::string& subject) {
  const Parts parts = parts_of(subject);
  if (parts.fingerprint.empty()) return subject;
  return std::string(parts.name) + "@" + std::string(parts.fingerprint.substr(0, kShownDigits));
}

bool is_meant(std::string_view text, const std::string& subject) {
  const Parts parts = parts_of(subject);
  if (text == subject || (!parts.name.empty() && text == parts.name)) return true;
  const std::size_t at = text.rfind('@');
  const std::string_view name = at == std::string_view::npos ? std::string_view{} : text.substr(0, at);
  const std::string_view digits = at == std::string_view::npos ? text : text.substr(at + 1);
  return digits.size() >= kShownDigits && parts.fingerprint.substr(0, digits.size()) == digits &&
         (name.empty() || parts.name.empty() || name == parts.name);
}

}  // namespace tessera::server
