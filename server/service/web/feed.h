// News for open pages, as server-sent events.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "service/farm/rights.h"
#include "service/web/board.h"
#include "service/web/event_stream.h"
#include "service/web/logins.h"
#include "service/web/pictures.h"
#include "telemetry/recent_lines.h"

namespace tessera::server {

/// The news that a page wants to hear.
struct FeedRequest {
  bool workers = false, log = false;                // news of these, besides jobs
  std::shared_ptr<ShownPicture> picture = nullptr;  // changes of this picture, too; null: none
};

/// Tells pages, a few times a second, what changed. Events, each one line of JSON:
///   jobs, workers  {"rows": [...], "gone": [ids], "all": true where all other rows are to be forgotten}
///   log            {"lines": [{"time", "level", "message", "job", "worker"}]}
///   picture        {"all": true | "areas": [x0, y0, x1, y1, ...]} of pixels that changed, and
///                  {"work": [[x0, y0, x1, y1, worker], ...]} where these changed
///   end            the session is over
class Feed {
 public:
  static constexpr std::size_t kMostStreams = 128;
  static constexpr std::size_t kMostOfMember = 16;       // streams of one, where members are known
  static constexpr std::size_t kMostInWork = 4096;       // tiles that are outlined
  static constexpr std::size_t kMostAreasAnEvent = 256;  // beyond, everything changed
  static constexpr std::size_t kRowsAnEvent = 1000;
  static constexpr std::chrono::milliseconds kPace{200};
  static constexpr std::chrono::milliseconds kSlice{100};  // part of each round that goes to results

  /// `lines` may be null. `admits` says whether a session still holds.
  Feed(const FarmViews& views, const Rights& rights, std::shared_ptr<telemetry::RecentLines> lines,
       std::function<bool(const Visitor&)> admits);
  ~Feed();

  /// ResourceExhausted when there are too many.
  absl::StatusOr<std::shared_ptr<EventStream>> open(const Visitor& who, FeedRequest asked);
  void stop();

 private:
  struct Listener {
    std::shared_ptr<EventStream> stream;
    Visitor who;
    FeedRequest asked;
    std::uint64_t jobs = 0, workers = 0, lines = 0;  // versions that it knows
    std::uint64_t picture_generation = 0, picture_changes = 0;
    std::string in_work;
    std::chrono::steady_clock::time_point last{};
  };
  /// The rows that one caller may see, shared by all of their pages.
  struct View {
    Board jobs, workers;
    std::map<std::string, bool> may_see;                          // jobs of lines
    std::chrono::steady_clock::time_point jobs_due, workers_due;  // times when they are looked at again
    bool used_in_round = false;
  };

  void run();
  void round();
  bool follow_pictures(const std::vector<std::shared_ptr<Listener>>& listeners);
  void look_at_jobs(const Caller& who, View& view);
  void look_at_workers(const Caller& who, View& view);
  void tell(Listener& listener, View& view);
  void tell_picture(Listener& listener);
  void tell_lines(Listener& listener, View& view);
  std::string key_of(const Caller& who) const;

  const FarmViews& farm_views_;
  const Rights rights_;
  const std::shared_ptr<telemetry::RecentLines> lines_;
  const std::function<bool(const Visitor&)> admits_;

  std::map<std::string, View> views_;  // used by the thread alone

  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<Listener>> listeners_;
  bool news_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace tessera::server
