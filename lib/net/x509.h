// Certificates and keys, between OpenSSL's objects and PEM.
#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/freer.h"

namespace tessera::net {

using Certificate = std::unique_ptr<X509, base::Freer<X509_free>>;
using CertificateRequest = std::unique_ptr<X509_REQ, base::Freer<X509_REQ_free>>;
using Key = std::unique_ptr<EVP_PKEY, base::Freer<EVP_PKEY_free>>;

/// Reads what stands first in `pem`; null when that is not of this kind.
Certificate certificate_from_pem(std::string_view pem);
CertificateRequest request_from_pem(std::string_view pem);
Key key_from_pem(std::string_view pem);

std::string to_pem(X509* certificate);
std::string to_pem(X509_REQ* request);
/// The private key.
std::string to_pem(EVP_PKEY* key);

/// SHA-256 of the certificate, in DER, as 64 hexadecimal digits.
std::string digest_of(X509* certificate);

/// SHA-256 of the public key (SubjectPublicKeyInfo, in DER), as 64 hexadecimal digits: the same for every
/// certificate of one key.
std::string key_digest_of(X509* certificate);
/// The same of the key that a request is for.
std::string key_digest_of(X509_REQ* request);

/// The URIs among its subject alternative names.
std::vector<std::string> uris_of(const X509* certificate);
/// The host names (DNS) among them.
std::vector<std::string> host_names_of(const X509* certificate);
/// Its common name; empty when it has none.
std::string name_of(const X509* certificate);

/// From when on it is valid; nothing when it does not say so.
std::optional<std::chrono::system_clock::time_point> begin_of(const X509* certificate);

/// Until when; likewise.
std::optional<std::chrono::system_clock::time_point> end_of(const X509* certificate);

/// Makes a key such as every program of a farm has: an elliptic key on P-256. Null when OpenSSL has none to
/// give.
Key make_key();
/// Whether it is one of those.
bool is_usual_key(EVP_PKEY* key);

/// Asks for a certificate for the holder of `key`, and proves that whoever asks is that.
CertificateRequest make_request(EVP_PKEY* key, const std::string& name);

}  // namespace tessera::net
