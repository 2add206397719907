// The farm's web page: what may be asked of it, and what is answered.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "service/farm/rights.h"
#include "service/web/feed.h"
#include "service/web/http.h"
#include "service/web/logins.h"
#include "service/web/pictures.h"
#include "telemetry/recent_lines.h"
#include "tls/expelled.h"
#include "tls/members.h"

namespace tessera::server {

class Farm;

struct SiteOptions {
  bool encrypted = false;  // callers are known by certificates and logins; else everybody may do everything
  std::string version;     // version of the program, for people
  std::shared_ptr<telemetry::RecentLines> lines = {};  // lines for the page of events; may be null
};

/// Answers requests, from any thread. Farm and lists outlive the site.
///
/// - GET /, /NAME.css, /NAME.js, ...: the page itself, from the program
/// - GET /api/me: who the caller is
/// - GET /api/events?workers&log&job&layer: news (feed.h), for as long as the connection holds
/// - GET /api/job?id: all that is known of a job
/// - GET /api/pixels?job&layer&level&x0&y0&x1&y1: Picture::pixels, counted from the crop's corner
/// - GET /api/spectrum?job&layer&x&y: ShownPicture::spectrum of a pixel, counted from the crop's corner
/// - POST /api/cancel, pause, resume, retry {"id"}; /api/priority {"id", "priority"}
/// - POST /api/login {"token"}; /api/logout
class WebSite {
 public:
  WebSite(Farm& farm, const Rights& rights, const Expelled& expelled, Members& members, SiteOptions options);

  /// Names by which the page may be called, besides addresses and "localhost".
  void set_names(std::vector<std::string> names);
  HttpAnswer answer(const HttpRequest& request);
  /// For MakeWebToken: a token with which its holder is `who`.
  absl::StatusOr<std::string> make_token(const Visitor& who, std::chrono::seconds life);
  bool needs_login() const { return options_.encrypted; }
  /// Ends all streams of events.
  void stop() { feed_.stop(); }

 private:
  HttpAnswer answer_api(const HttpRequest& request);
  HttpAnswer read(const HttpRequest& request, const Visitor& who);
  HttpAnswer change(const HttpRequest& request, const Visitor& who);
  HttpAnswer log_in(const HttpRequest& request);
  HttpAnswer log_out(const HttpRequest& request);
  HttpAnswer events(const HttpRequest& request, const Visitor& who);
  HttpAnswer pixels(const HttpRequest& request, const Visitor& who);
  HttpAnswer spectrum(const HttpRequest& request, const Visitor& who);
  /// The picture of the job's colours, and whether it has results that were not read yet.
  struct ColorPicture {
    std::shared_ptr<ShownPicture> picture;
    bool more = false;
  };
  absl::StatusOr<ColorPicture> color_picture(const HttpRequest& request, const Visitor& who);
  HttpAnswer meter(const HttpRequest& request, const Visitor& who);
  HttpAnswer units(const HttpRequest& request, const Visitor& who);
  /// Unauthenticated for somebody who is not known, PermissionDenied for somebody who was expelled or whose
  /// role is not for `method` (is_allowed).
  absl::StatusOr<Visitor> identify(const HttpRequest& request, const std::string& method) const;
  bool is_admitted(const Visitor& who) const;
  std::shared_ptr<const std::vector<std::string>> names() const;

  Farm& farm_;
  const Rights rights_;
  const Expelled& expelled_;
  Members& members_;
  const SiteOptions options_;
  mutable std::mutex names_mutex_;
  std::shared_ptr<const std::vector<std::string>> names_ = std::make_shared<const std::vector<std::string>>();
  mutable Logins logins_;
  Pictures pictures_;
  Feed feed_;
};

/// Status of HTTP that says the same.
unsigned http_status(const absl::Status& status);

}  // namespace tessera::server
