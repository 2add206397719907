#include "service/farm/accounts.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

struct Kind {
  std::uint64_t Holding::*amount;
  const char* name;
};
constexpr std::array kKinds{Kind{&Holding::registrations, "registered workers"},
                            Kind{&Holding::calls, "waiting calls"}, Kind{&Holding::streams, "open streams"},
                            Kind{&Holding::bytes, "bytes of registrations and waiting calls"}};

}  // namespace

std::string holder_of(const std::string& certificate, const std::string& peer) {
  return certificate.empty() ? peer.substr(0, peer.rfind(':')) : certificate;
}

Accounts::Hold::Hold(std::shared_ptr<Accounts> accounts, std::string holder, const Holding& amount)
    : accounts_(std::move(accounts)), holder_(std::move(holder)), amount_(amount) {}

Accounts::Hold::~Hold() { accounts_->give_back(holder_, amount_); }

absl::StatusOr<std::shared_ptr<const Accounts::Hold>> Accounts::take(const std::string& holder,
                                                                     const Holding& amount) {
  const std::lock_guard lock(mutex_);
  const auto found = held_.find(holder);
  Holding sum = found == held_.end() ? Holding{} : found->second;
  for (const Kind& kind : kKinds) {
    sum.*kind.amount += amount.*kind.amount;
    if (amount.*kind.amount == 0 || sum.*kind.amount <= limits_.*kind.amount) continue;
    return absl::ResourceExhaustedError(
        absl::StrCat("'", holder, "' has too much at a time of this coordinator: ", sum.*kind.amount, " ",
                     kind.name, "; at most ", limits_.*kind.amount, " are taken of one"));
  }
  held_[holder] = sum;
  return std::make_shared<const Hold>(shared_from_this(), holder, amount);
}

void Accounts::give_back(const std::string& holder, const Holding& amount) {
  const std::lock_guard lock(mutex_);
  const auto found = held_.find(holder);
  bool nothing_left = true;
  for (const Kind& kind : kKinds) {
    found->second.*kind.amount -= amount.*kind.amount;
    nothing_left &= found->second.*kind.amount == 0;
  }
  if (nothing_left) held_.erase(found);
}

Holding Accounts::held_by(const std::string& holder) const {
  const std::lock_guard lock(mutex_);
  const auto found = held_.find(holder);
  return found == held_.end() ? Holding{} : found->second;
}

std::size_t Accounts::holders() const {
  const std::lock_guard lock(mutex_);
  return held_.size();
}

}  // namespace tessera::server
