#include "net/x509.h"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <array>
#include <ctime>

#include "wire/digest.h"

namespace tessera::net {
namespace {

using Bio = std::unique_ptr<BIO, base::Freer<BIO_free_all>>;

/// Without it, OpenSSL would ask for the password of what is encrypted, at the terminal, whoever sent it.
int no_password(char*, int, int, void*) { return -1; }

/// Returns what `read` finds in `pem`; its errors are forgotten.
template <class Read>
auto read_from(std::string_view pem, Read read) {
  const Bio bio{BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()))};
  auto* const object = read(bio.get(), nullptr, no_password, nullptr);
  ERR_clear_error();
  return object;
}

/// Returns what `write` writes.
template <class Write>
std::string written_by(Write write) {
  const Bio bio{BIO_new(BIO_s_mem())};
  write(bio.get());
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

/// Subject alternative names of one type whose value is text (GEN_URI, GEN_DNS).
std::vector<std::string> names_of_type(const X509* certificate, int type) {
  const std::unique_ptr<GENERAL_NAMES, base::Freer<GENERAL_NAMES_free>> names{
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr))};
  std::vector<std::string> texts;
  for (int i = 0; names != nullptr && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type != type) continue;
    const ASN1_IA5STRING* const text = name->d.ia5;
    texts.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                       static_cast<std::size_t>(ASN1_STRING_length(text)));
  }
  return texts;
}

}  // namespace

Certificate certificate_from_pem(std::string_view pem) {
  return Certificate{read_from(pem, PEM_read_bio_X509)};
}
CertificateRequest request_from_pem(std::string_view pem) {
  return CertificateRequest{read_from(pem, PEM_read_bio_X509_REQ)};
}
Key key_from_pem(std::string_view pem) { return Key{read_from(pem, PEM_read_bio_PrivateKey)}; }

std::string to_pem(X509* certificate) {
  return written_by([&](BIO* bio) { PEM_write_bio_X509(bio, certificate); });
}
std::string to_pem(X509_REQ* request) {
  return written_by([&](BIO* bio) { PEM_write_bio_X509_REQ(bio, request); });
}
std::string to_pem(EVP_PKEY* key) {
  return written_by(
      [&](BIO* bio) { PEM_write_bio_PrivateKey(bio, key, nullptr, nullptr, 0, nullptr, nullptr); });
}

std::string digest_of(X509* certificate) {
  return wire::sha256_hex(written_by([&](BIO* bio) { i2d_X509_bio(bio, certificate); }));
}

std::string key_digest_of(X509* certificate) {
  return wire::sha256_hex(written_by([&](BIO* bio) { i2d_PUBKEY_bio(bio, X509_get0_pubkey(certificate)); }));
}

std::string key_digest_of(X509_REQ* request) {
  return wire::sha256_hex(written_by([&](BIO* bio) { i2d_PUBKEY_bio(bio, X509_REQ_get0_pubkey(request)); }));
}

std::vector<std::string> uris_of(const X509* certificate) { return names_of_type(certificate, GEN_URI); }

std::vector<std::string> host_names_of(const X509* certificate) {
  return names_of_type(certificate, GEN_DNS);
}

std::string name_of(const X509* certificate) {
  X509_NAME* const subject = X509_get_subject_name(certificate);
  const int place = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (place < 0) return "";
  const ASN1_STRING* const name = X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, place));
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(name)),
          static_cast<std::size_t>(ASN1_STRING_length(name))};
}

namespace {

std::optional<std::chrono::system_clock::time_point> time_point_of(const ASN1_TIME* asn1) {
  std::tm time{};
  if (asn1 == nullptr || ASN1_TIME_to_tm(asn1, &time) != 1) return std::nullopt;
  return std::chrono::system_clock::from_time_t(::timegm(&time));
}

}  // namespace

std::optional<std::chrono::system_clock::time_point> begin_of(const X509* certificate) {
  return time_point_of(X509_get0_notBefore(certificate));
}

std::optional<std::chrono::system_clock::time_point> end_of(const X509* certificate) {
  return time_point_of(X509_get0_notAfter(certificate));
}

Key make_key() { return Key{EVP_EC_gen("P-256")}; }

bool is_usual_key(EVP_PKEY* key) {
  std::array<char, 64> group{};
  const bool named = EVP_PKEY_get_group_name(key, group.data(), group.size(), nullptr) == 1;
  ERR_clear_error();
  return named && std::string_view{group.data()} == SN_X9_62_prime256v1;
}

CertificateRequest make_request(EVP_PKEY* key, const std::string& name) {
  CertificateRequest request{X509_REQ_new()};
  const auto* const text = reinterpret_cast<const unsigned char*>(name.data());
  const bool made =
      X509_REQ_set_pubkey(request.get(), key) == 1 &&
      X509_NAME_add_entry_by_NID(X509_REQ_get_subject_name(request.get()), NID_commonName, MBSTRING_UTF8,
                                 text, static_cast<int>(name.size()), -1, 0) == 1 &&
      X509_REQ_sign(request.get(), key, EVP_sha256()) > 0;
  ERR_clear_error();
  return made ? std::move(request) : nullptr;
}

}  // namespace tessera::net
