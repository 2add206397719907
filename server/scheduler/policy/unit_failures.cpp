#include "scheduler/policy/unit_failures.h"

#include <algorithm>

namespace tessera::server {

std::set<std::string> hosts_of(const std::vector<UnitFailure>& failures) {
  std::set<std::string> hosts;
  for (const UnitFailure& failure : failures) hosts.insert(failure.host);
  return hosts;
}

std::size_t losses_in(const std::vector<UnitFailure>& failures) {
  return static_cast<std::size_t>(std::count_if(failures.begin(), failures.end(),
                                                [](const UnitFailure& failure) { return failure.lost; }));
}

bool is_disputed(const std::vector<UnitFailure>& failures) {
  return std::any_of(failures.begin(), failures.end(),
                     [](const UnitFailure& failure) { return failure.disputed; });
}

bool failed_too_often(const std::vector<UnitFailure>& failures) {
  return failures.size() - losses_in(failures) >= kMaxFailures || hosts_of(failures).size() >= kMaxFailures ||
         failures.size() >= kMaxLosses || is_disputed(failures);
}

}  // namespace tessera::server
