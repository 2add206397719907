#include "service/web/feed.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "service/farm/farm_views.h"
#include "service/web/json_text.h"

namespace tessera::server {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

// A connection that is gone is noticed by writing to it.
constexpr std::chrono::seconds kSilence{5};

void push_rows(EventStream& stream, const char* event, const Board::News& news) {
  std::size_t at = 0;
  bool first = true;
  do {
    const std::size_t end = std::min(at + Feed::kRowsAnEvent, news.rows.size());
    const std::vector<std::string> rows(news.rows.begin() + static_cast<std::ptrdiff_t>(at),
                                        news.rows.begin() + static_cast<std::ptrdiff_t>(end));
    stream.push(event, absl::StrCat("{\"rows\":[", absl::StrJoin(rows, ","),
                                    "],\"gone\":", json_text(first ? Json(news.gone) : Json::array()),
                                    ",\"all\":", first && news.all ? "true" : "false",
                                    ",\"more\":", end < news.rows.size() ? "true" : "false", "}"));
    at = end;
    first = false;
  } while (at < news.rows.size());
}

/// Looks when it is due, and then not before nine times as long has passed as that took: ten thousand workers
/// are looked at less often than ten.
template <class Look>
void at_leisure(Clock::time_point& due, Look&& look) {
  const Clock::time_point begin = Clock::now();
  if (begin < due) return;
  look();
  const Clock::time_point end = Clock::now();
  due = end + 9 * (end - begin);
}

}  // namespace

Feed::Feed(const FarmViews& views, const Rights& rights, std::shared_ptr<telemetry::RecentLines> lines,
           std::function<bool(const Visitor&)> admits)
    : farm_views_(views), rights_(rights), lines_(std::move(lines)), admits_(std::move(admits)) {
  thread_ = std::thread([this] { run(); });
}

Feed::~Feed() { stop(); }

void Feed::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    wake_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  for (const auto& listener : listeners_) listener->stream->close();
  listeners_.clear();
}

absl::StatusOr<std::shared_ptr<EventStream>> Feed::open(const Visitor& who, FeedRequest asked) {
  const std::lock_guard lock(mutex_);
  if (stop_) return absl::UnavailableError("the coordinator is shutting down");
  std::erase_if(listeners_, [](const auto& listener) { return listener->stream->closed(); });
  if (listeners_.size() >= kMostStreams) return absl::ResourceExhaustedError("too many pages are open");
  const std::string member = name_of_member(who);
  const auto is_of_member = [&](const auto& listener) { return name_of_member(listener->who) == member; };
  if (!member.empty() &&
      std::cmp_greater_equal(std::ranges::count_if(listeners_, is_of_member), kMostOfMember)) {
    return absl::ResourceExhaustedError(absl::StrCat("more than ", kMostOfMember, " pages of '",
                                                     who.caller.user, "' are open: close some of them"));
  }
  auto listener = std::make_shared<Listener>();
  listener->stream = std::make_shared<EventStream>();
  listener->who = who;
  listener->asked = std::move(asked);
  listeners_.push_back(listener);
  news_ = true;
  wake_.notify_all();
  return listener->stream;
}

void Feed::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    // Rounds come at this pace while somebody listens; farms change all the time.
    const auto due = [this] { return stop_ || news_; };
    listeners_.empty() ? wake_.wait(lock, due) : static_cast<void>(wake_.wait_for(lock, kPace, due));
    if (stop_) return;
    news_ = false;
    lock.unlock();
    round();
    lock.lock();
  }
}

std::string Feed::key_of(const Caller& who) const {
  return rights_.sees_all(who) ? "" : absl::StrCat("user ", who.user);
}

bool Feed::follow_pictures(const std::vector<std::shared_ptr<Listener>>& listeners) {
  std::vector<std::shared_ptr<ShownPicture>> pictures;
  for (const auto& listener : listeners) {
    const auto& picture = listener->asked.picture;
    if (picture != nullptr && std::ranges::find(pictures, picture) == pictures.end())
      pictures.push_back(picture);
  }
  bool more = false;
  for (const auto& picture : pictures)
    more |= picture->follow(Clock::now() + kSlice / static_cast<int>(pictures.size()));
  return more;
}

void Feed::round() {
  std::vector<std::shared_ptr<Listener>> listeners;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(listeners_, [](const auto& listener) { return listener->stream->closed(); });
    listeners = listeners_;
  }
  const bool more = follow_pictures(listeners);
  for (auto& [key, view] : views_) view.used_in_round = false;
  for (const auto& listener : listeners) tell(*listener, views_[key_of(listener->who.caller)]);
  std::erase_if(views_, [](const auto& entry) { return !entry.second.used_in_round; });
  if (!more) return;
  const std::lock_guard lock(mutex_);
  news_ = true;
}

void Feed::look_at_jobs(const Caller& who, View& view) {
  Board::Rows rows;
  view.may_see.clear();
  const v1::ListJobsResponse jobs = rights_.jobs(who);
  for (const v1::JobStatus& job : jobs.jobs()) {
    rows.emplace_back(job.job_id(), row_of(job));
    view.may_see[job.job_id()] = true;
  }
  view.jobs.update(std::move(rows));
}

void Feed::look_at_workers(const Caller& who, View& view) {
  Board::Rows rows;
  const v1::ListWorkersResponse workers = rights_.workers(who);
  const std::chrono::milliseconds heartbeats = farm_views_.heartbeat_interval();
  for (const v1::WorkerStatus& worker : workers.workers())
    rows.emplace_back(worker.worker_id(), row_of(worker, heartbeats));
  view.workers.update(std::move(rows));
}

void Feed::tell(Listener& listener, View& view) {
  const Caller& who = listener.who.caller;
  view.used_in_round = true;
  at_leisure(view.jobs_due, [&] { look_at_jobs(who, view); });
  EventStream& stream = *listener.stream;
  if (!stream.idle()) return;  // it has not taken the last news yet
  const auto now = Clock::now();
  if (now - listener.last > kSilence) {
    if (!admits_(listener.who)) {
      stream.push("end", "{}");
      return stream.close();
    }
    listener.last = now;
    stream.push_comment();
  }
  if (const Board::News news = view.jobs.since(listener.jobs); !news.empty()) push_rows(stream, "jobs", news);
  listener.jobs = view.jobs.version();
  if (listener.asked.workers) {
    at_leisure(view.workers_due, [&] { look_at_workers(who, view); });
    if (const Board::News news = view.workers.since(listener.workers); !news.empty())
      push_rows(stream, "workers", news);
    listener.workers = view.workers.version();
  }
  if (listener.asked.log) tell_lines(listener, view);
  if (listener.asked.picture != nullptr) tell_picture(listener);
}

void Feed::tell_lines(Listener& listener, View& view) {
  if (lines_ == nullptr) return;
  Json lines = Json::array();
  for (const telemetry::LogLine& line : lines_->after(listener.lines)) {
    listener.lines = line.number;
    const Caller& who = listener.who.caller;
    // Lines of one's own jobs, and of oneself; who sees all sees the farm's, too.
    if (!rights_.sees_all(who) && line.user != who.user && !view.may_see.contains(line.job)) continue;
    lines.push_back({{"time", line.unix_ms},
                     {"level", line.level},
                     {"message", line.message},
                     {"job", line.job},
                     {"worker", line.worker}});
  }
  if (!lines.empty()) listener.stream->push("log", json_text({{"lines", std::move(lines)}}));
}

void Feed::tell_picture(Listener& listener) {
  ShownPicture& picture = *listener.asked.picture;
  const ShownPicture::News news = picture.since(listener.picture_generation, listener.picture_changes);
  Json event = Json::object();
  if (news.all || news.areas.size() > kMostAreasAnEvent) {
    event["all"] = true;
  } else if (!news.areas.empty()) {
    Json areas = Json::array();
    for (const PixelArea& area : news.areas)
      for (const std::uint32_t edge : {area.x0, area.y0, area.x1, area.y1}) areas.push_back(edge);
    event["areas"] = std::move(areas);
  }
  listener.picture_generation = news.generation;
  listener.picture_changes = news.changes;
  Json work = Json::array();
  for (const PixelsInWork& at : farm_views_.in_work(picture.job(), kMostInWork))
    work.push_back({at.pixels.x0(), at.pixels.y0(), at.pixels.x1(), at.pixels.y1(), at.worker});
  if (std::string text = json_text(work); text != listener.in_work) {
    listener.in_work = std::move(text);
    event["work"] = std::move(work);
  }
  if (!event.empty()) listener.stream->push("picture", json_text(event));
}

}  // namespace tessera::server
