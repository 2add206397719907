#include "farm/contact.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "net/status.h"

namespace tessera::client {

Contact::Contact(std::string address, std::chrono::milliseconds first_patience,
                 std::chrono::milliseconds later_patience, Notice notice, Wait wait)
    : address_(std::move(address)),
      first_patience_(first_patience),
      later_patience_(later_patience),
      notice_(std::move(notice)),
      wait_(std::move(wait)) {}

void Contact::succeeded() {
  if (broken_ && reached_) notice_(absl::StrCat("the coordinator at ", address_, " answers again"));
  reached_ = true;
  broken_ = false;
  backoff_.reset();
}

absl::Status Contact::failed(const absl::Status& status, std::stop_token stop) {
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  if (!net::is_transient(status)) return status;
  if (!broken_) {
    broken_ = true;
    broken_since_ = Clock::now();
    if (reached_) {
      notice_(absl::StrCat("trouble with the coordinator at ", address_, " (", status.message(),
                           "); trying again"));
    }
  }
  if (Clock::now() - broken_since_ >= (reached_ ? later_patience_ : first_patience_)) return status;
  return wait_(backoff_.next(), stop) ? absl::OkStatus() : absl::CancelledError("interrupted");
}

}  // namespace tessera::client
