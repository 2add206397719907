// Names of hosts, and who answers for them.
//
// A host is a fault domain: what fails there says nothing of others. Who answers for it is its identity: the
// key of the certificate that its workers call with. Where there are certificates, a host is called
// "NAME@FINGERPRINT": its name is its own word, the fingerprint is proven. So whoever has one key may invent
// hosts, but not identities. Where there are none, a host is called by its name, and is its own identity.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera::server {

/// Digits of a key's SHA-256 in a fingerprint: 128 bits, so that nobody finds a second key for a fingerprint.
inline constexpr std::size_t kFingerprintDigits = 32;
/// That people see, and may give instead of all.
inline constexpr std::size_t kShownDigits = 8;

/// `fingerprint` is empty where there are no certificates.
std::string host_named(const std::string& name, const std::string& fingerprint);

/// The fingerprint of a host, or the host itself where it has none.
std::string identity_of(const std::string& host);

/// Whether `subject`, a host or an identity, is this host or answers for it.
bool covers(const std::string& subject, const std::string& host);

/// "NAME@FINGERPR" for a host, "@FINGERPR" for an identity: short enough for tables, and understood by
/// `is_meant`.
std::string short_name(const std::string& subject);

/// Whether a person who says `text` means this host or identity: its name, its fingerprint (from kShownDigits
/// digits on), or both with "@" between.
bool is_meant(std::string_view text, const std::string& subject);

}  // namespace tessera::server
