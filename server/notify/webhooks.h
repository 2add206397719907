// Tells webhooks of the ends of jobs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "service/job/end_listener.h"

namespace tessera::server {

struct WebhookOptions {
  std::string url;                        // told of all jobs; empty: none
  std::vector<std::string> allowed_urls;  // URLs that single jobs may name (check_allowed)
  std::string signing_key;
  int attempts = 10;
  std::chrono::milliseconds first_delay{1000};  // doubled after each attempt, to two minutes at most
  std::chrono::milliseconds attempt_timeout{10'000};
};

/// Posts messages (webhook_message.h) from threads of its own. What cannot be delivered for now is tried
/// again: no answer, 408, 429 and 5xx; anything else that is not 2xx is final. Redirections are not followed,
/// no proxy is used, and what is answered is not read. At most 1024 messages wait, all of them in memory: a
/// coordinator that ends gives up those that are left, and logs how many.
class Webhooks final : public EndListener {
 public:
  explicit Webhooks(WebhookOptions options);
  ~Webhooks() override;

  absl::Status check_webhook(const std::string& url) const override;
  void ended(const v1::JobStatus& status, const std::string& webhook) override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Delivery {
    std::string job, url, body, id;
    int attempts = 0;
  };
  enum class Outcome { kDelivered, kLater, kRefused };

  void run();
  /// Posts the message once; says in `why` what went wrong.
  Outcome post(const Delivery& delivery, std::string& why) const;
  void put_off(Delivery delivery, const std::string& why);
  bool stopping() const;

  const WebhookOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::multimap<Clock::time_point, Delivery> waiting_by_due_time_;
  std::uint64_t count_ = 0;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tessera::server
