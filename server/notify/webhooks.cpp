#include "notify/webhooks.h"

#include <curl/curl.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "notify/webhook_message.h"
#include "notify/webhook_url.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

constexpr std::size_t kMostWaiting = 1024;
constexpr int kThreads = 4;  // so that a receiver that is slow to answer does not hold up the others
constexpr std::chrono::milliseconds kLongestDelay{120'000};

std::size_t discard(char*, std::size_t size, std::size_t count, void*) { return size * count; }

std::int64_t unix_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Webhooks::Webhooks(WebhookOptions options) : options_(std::move(options)) {
  curl_global_init(CURL_GLOBAL_DEFAULT);
  for (int i = 0; i < kThreads; ++i) threads_.emplace_back([this] { run(); });
}

Webhooks::~Webhooks() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  if (!waiting_by_due_time_.empty())
    spdlog::warn("webhooks: {} messages were not delivered", waiting_by_due_time_.size());
}

absl::Status Webhooks::check_webhook(const std::string& url) const {
  return check_allowed(url, options_.allowed_urls);
}

void Webhooks::ended(const v1::JobStatus& status, const std::string& webhook) {
  // The list of those that are allowed may have changed since the job was submitted.
  const bool own = !webhook.empty() && webhook != options_.url && check_webhook(webhook).ok();
  const std::string body = end_message(status);
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& url : {options_.url, own ? webhook : std::string()}) {
      if (url.empty()) continue;
      if (waiting_by_due_time_.size() >= kMostWaiting) {
        spdlog::error("webhooks: {} messages wait already; the end of job {} is not told",
                      waiting_by_due_time_.size(), status.job_id());
        continue;
      }
      const std::string id = absl::StrCat(status.job_id(), "-", status.finished_unix_ms(), "-", count_++);
      waiting_by_due_time_.emplace(Clock::now(),
                                   Delivery{.job = status.job_id(), .url = url, .body = body, .id = id});
    }
  }
  wake_.notify_all();
}

void Webhooks::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (waiting_by_due_time_.empty()) {
      wake_.wait(lock);
      continue;
    }
    const auto first = waiting_by_due_time_.begin();
    if (const Clock::time_point due = first->first; due > Clock::now()) {
      wake_.wait_until(lock, due);
      continue;
    }
    Delivery delivery = std::move(waiting_by_due_time_.extract(first).mapped());
    lock.unlock();
    std::string why;
    const Outcome outcome = post(delivery, why);
    ++delivery.attempts;
    lock.lock();
    if (outcome == Outcome::kLater && delivery.attempts < options_.attempts) {
      put_off(std::move(delivery), why);
    } else if (outcome != Outcome::kDelivered) {
      telemetry::log(spdlog::level::err, {.job = delivery.job}, "webhook {}: {}; given up after {} attempts",
                     delivery.url, why, delivery.attempts);
    }
  }
}

void Webhooks::put_off(Delivery delivery, const std::string& why) {
  const std::chrono::milliseconds delay =
      std::min(options_.first_delay * (1 << std::min(delivery.attempts - 1, 20)), kLongestDelay);
  telemetry::log(spdlog::level::warn, {.job = delivery.job}, "webhook {}: {}; tried again in {} ms",
                 delivery.url, why, delay.count());
  waiting_by_due_time_.emplace(Clock::now() + delay, std::move(delivery));
}

bool Webhooks::stopping() const {
  const std::lock_guard lock(mutex_);
  return stop_;
}

Webhooks::Outcome Webhooks::post(const Delivery& delivery, std::string& why) const {
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(), curl_easy_cleanup);
  if (curl == nullptr) return why = "no memory", Outcome::kLater;
  const std::int64_t now = unix_seconds();
  const std::string lines[] = {
      "Content-Type: application/json",
      "User-Agent: tessera-server",
      "Expect:",
      absl::StrCat("X-Tessera-Delivery: ", delivery.id),
      absl::StrCat("X-Tessera-Timestamp: ", now),
      absl::StrCat("X-Tessera-Signature: ", signature_of(options_.signing_key, now, delivery.body))};
  curl_slist* list = nullptr;
  for (const std::string& line : lines) list = curl_slist_append(list, line.c_str());
  const std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers(list, curl_slist_free_all);

  curl_easy_setopt(curl.get(), CURLOPT_URL, delivery.url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl.get(), CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(curl.get(), CURLOPT_PROXY, "");  // nor the environment's
  curl_easy_setopt(curl.get(), CURLOPT_NETRC, long{CURL_NETRC_IGNORED});
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_TIMEOUT_MS, static_cast<long>(options_.attempt_timeout.count()));
  curl_easy_setopt(curl.get(), CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDSIZE, static_cast<long>(delivery.body.size()));
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDS, delivery.body.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, &discard);
  curl_easy_setopt(curl.get(), CURLOPT_NOPROGRESS, 0L);
  curl_easy_setopt(curl.get(), CURLOPT_XFERINFODATA, this);
  curl_easy_setopt(
      curl.get(), CURLOPT_XFERINFOFUNCTION, +[](void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
        return static_cast<const Webhooks*>(self)->stopping() ? 1 : 0;  // 1 ends the transfer
      });
  if (const CURLcode code = curl_easy_perform(curl.get()); code != CURLE_OK)
    return why = curl_easy_strerror(code), Outcome::kLater;
  long answer = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &answer);
  if (answer / 100 == 2) return Outcome::kDelivered;
  why = absl::StrCat("answered ", answer, answer / 100 == 3 ? " (redirections are not followed)" : "");
  return answer / 100 == 5 || answer == 408 || answer == 429 ? Outcome::kLater : Outcome::kRefused;
}

}  // namespace tessera::server
