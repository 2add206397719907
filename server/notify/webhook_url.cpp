#include "notify/webhook_url.h"

#include <curl/curl.h>

#include <algorithm>
#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

struct Url {
  std::string scheme, host, port, path;
};

/// A part of the URL; empty where it has none.
std::string part_of(CURLU* url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, flags) != CURLUE_OK) return "";
  const std::unique_ptr<char, decltype(&curl_free)> owner(text, curl_free);
  return text;
}

absl::Status unsound(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("webhook: ", what));
}

absl::StatusOr<Url> parse(const std::string& text) {
  if (std::ranges::any_of(text, [](unsigned char c) { return c <= ' ' || c >= 127 || c == '\\'; }))
    return unsound("a URL has no blanks, backslashes or characters beyond ASCII");
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url(curl_url(), curl_url_cleanup);
  if (url == nullptr || curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK)
    return unsound("expected a URL, as in https://hooks.example.com/tessera");
  Url parts{absl::AsciiStrToLower(part_of(url.get(), CURLUPART_SCHEME)),
            absl::AsciiStrToLower(part_of(url.get(), CURLUPART_HOST)),
            part_of(url.get(), CURLUPART_PORT, CURLU_DEFAULT_PORT), part_of(url.get(), CURLUPART_PATH)};
  if (parts.scheme != "http" && parts.scheme != "https") return unsound("expected http or https");
  if (parts.host.empty()) return unsound("it has no host");
  if (!part_of(url.get(), CURLUPART_USER).empty() || !part_of(url.get(), CURLUPART_PASSWORD).empty())
    return unsound("it has a user or a password, which everybody who sees the job would read");
  if (!part_of(url.get(), CURLUPART_FRAGMENT).empty()) return unsound("it has a fragment");
  const std::string path = absl::AsciiStrToLower(parts.path);
  for (const char* encoded : {"%2e", "%2f", "%5c", "%00"}) {
    if (absl::StrContains(path, encoded))
      return unsound(absl::StrCat("its path has ", encoded, ", which servers read in different ways"));
  }
  return parts;
}

bool covers(const Url& allowed, const Url& url) {
  if (allowed.scheme != url.scheme || allowed.host != url.host || allowed.port != url.port) return false;
  return url.path == allowed.path ||
         (absl::EndsWith(allowed.path, "/") && absl::StartsWith(url.path, allowed.path));
}

}  // namespace

absl::Status check_url(const std::string& url) { return parse(url).status(); }

absl::Status check_allowed(const std::string& url, const std::vector<std::string>& allowed) {
  const absl::StatusOr<Url> asked = parse(url);
  if (!asked.ok()) return absl::PermissionDeniedError(asked.status().message());
  for (const std::string& prefix : allowed) {
    const absl::StatusOr<Url> permitted = parse(prefix);
    if (permitted.ok() && covers(*permitted, *asked)) return absl::OkStatus();
  }
  return absl::PermissionDeniedError(absl::StrCat("webhook: the coordinator calls no ", asked->scheme, "://",
                                                  asked->host, ":", asked->port, asked->path,
                                                  " (tessera-server --webhook-allow)"));
}

}  // namespace tessera::server
