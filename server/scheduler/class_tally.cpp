#include "scheduler/class_tally.h"

#include <algorithm>

#include "absl/container/flat_hash_set.h"
#include "scheduler/identity.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {
namespace {

bool contains_all(const std::vector<std::string>& tags, const std::vector<std::string>& required) {
  return std::all_of(required.begin(), required.end(), [&](const std::string& tag) {
    return std::find(tags.begin(), tags.end(), tag) != tags.end();
  });
}

/// Whether the class will do: it is `needed`, or where that is empty, of the ISA.
bool fits(const std::string& name, const std::string& needed, std::string_view isa) {
  return needed.empty() ? isa.empty() || wire::isa_of(name) == isa : name == needed;
}

// Demands that answers are kept for.
constexpr std::size_t kMostAnswers = 1024;

/// Threads of at most so many workers.
std::uint64_t threads_of(std::vector<std::pair<std::uint32_t, std::uint64_t>> workers,
                         std::uint32_t max_workers) {
  std::sort(workers.rbegin(), workers.rend());
  std::uint64_t sum = 0, left = max_workers == 0 ? UINT64_MAX : max_workers;
  for (const auto& [threads, count] : workers) {
    const std::uint64_t taken = std::min(left, count);
    sum += taken * threads;
    left -= taken;
  }
  return sum;
}

}  // namespace

bool has_tags(const WorkerInfo& worker, const std::vector<std::string>& required) {
  return contains_all(worker.tags, required);
}

/// Workers that a class has to offer.
struct ClassTally::Offer {
  using Workers = std::vector<std::pair<std::uint32_t, std::uint64_t>>;  // threads of each, how many of them
  Workers workers, supporting;                                           // of any identity; of supporters
  std::uint64_t dislike = 0;  // threads, each times the place of the class among those of its worker
  absl::flat_hash_set<std::string_view> identities, supporters;
};

void ClassTally::add(const WorkerInfo& worker, std::uint32_t threads) {
  Group& group = groups_[{worker.classes, worker.tags, threads}];
  ++group.workers;
  ++group.worker_count_by_identity[identity_of(worker.host)];
  ++revision_;
}

void ClassTally::remove(const WorkerInfo& worker, std::uint32_t threads) {
  const auto kind = groups_.find({worker.classes, worker.tags, threads});
  Group& group = kind->second;
  const auto identity = group.worker_count_by_identity.find(identity_of(worker.host));
  if (--identity->second == 0) group.worker_count_by_identity.erase(identity);
  if (--group.workers == 0) groups_.erase(kind);
  ++revision_;
}

bool ClassTally::confirm(const std::string& name, const std::string& identity) {
  if (!confirmed_.contains(name) && confirmed_.size() >= kMostConfirmedClasses) return false;
  std::set<std::string>& identities = confirmed_[name];
  if (identities.size() >= kMostConfirmedIdentities || !identities.insert(identity).second) return false;
  ++revision_;
  return true;
}

bool ClassTally::is_confirmed(const std::string& name, const std::string& identity) const {
  const auto confirmed = confirmed_.find(name);
  return confirmed != confirmed_.end() && confirmed->second.contains(identity);
}

bool ClassTally::has(const std::vector<std::string>& classes) const {
  const auto kind = groups_.lower_bound({classes, {}, 0});
  return kind != groups_.end() && std::get<0>(kind->first) == classes;
}

bool ClassTally::offers(const std::string& name, const std::vector<std::string>& tags) const {
  return std::any_of(groups_.begin(), groups_.end(), [&](const auto& entry) {
    const auto& [classes, its_tags, threads] = entry.first;
    return std::find(classes.begin(), classes.end(), name) != classes.end() && contains_all(its_tags, tags);
  });
}

std::string ClassTally::best(const Demand& demand) const {
  if (answers_revision_ != revision_ || answers_.size() >= kMostAnswers) answers_.clear();
  answers_revision_ = revision_;
  const auto [answer, is_new] =
      answers_.try_emplace({std::string(demand.isa), demand.tags, demand.max_workers});
  if (is_new) answer->second = choose(demand);
  return answer->second;
}

/// Counts identities of one kind of machines, and those of them whose threads are believed.
void ClassTally::add_support(const std::string& name, const Group& group, std::uint32_t threads,
                             Offer& offer) const {
  const auto confirmed = confirmed_.find(name);
  const bool named = named_.contains(name);
  for (const auto& [identity, count] : group.worker_count_by_identity) {
    offer.identities.insert(identity);
    if (!named && (confirmed == confirmed_.end() || !confirmed->second.contains(identity))) continue;
    offer.supporters.insert(identity);
    offer.supporting.emplace_back(threads, count);
  }
}

std::string ClassTally::choose(const Demand& demand) const {
  std::map<std::string, Offer> offers;
  for (const auto& [kind, group] : groups_) {
    const auto& [classes, tags, threads] = kind;
    if (!contains_all(tags, demand.tags)) continue;
    for (std::size_t place = 0; place < classes.size(); ++place) {
      const auto here = classes.begin() + static_cast<std::ptrdiff_t>(place);
      const bool again = std::find(classes.begin(), here, *here) != here;
      if (again || !fits(*here, "", demand.isa)) continue;
      Offer& offer = offers[classes[place]];
      offer.workers.emplace_back(threads, group.workers);
      offer.dislike += place * threads * group.workers;
      add_support(classes[place], group, threads, offer);
    }
  }
  // Two are needed for a result to be confirmed, however few may work at a time; more than may work do not
  // count.
  const std::size_t most = demand.max_workers == 0 ? SIZE_MAX : std::max<std::size_t>(2, demand.max_workers);
  const auto rank = [&](const auto& entry) {
    const Offer& offer = entry.second;
    const bool backed = named_.contains(entry.first) || offer.supporters.size() >= 2;
    return std::tuple{backed, backed ? 0 : std::min(most, offer.identities.size()),
                      threads_of(backed ? offer.supporting : offer.workers, demand.max_workers),
                      ~offer.dislike};
  };
  const auto best =
      std::max_element(offers.begin(), offers.end(), [&](auto& a, auto& b) { return rank(a) < rank(b); });
  return best == offers.end() ? "" : best->first;
}

std::map<std::string, ClassTally::LeftOut> ClassTally::without(const std::string& needed,
                                                               const Demand& demand) const {
  std::map<std::string, LeftOut> left_out;
  for (const auto& [kind, machines] : groups_) {
    const auto& [classes, tags, threads] = kind;
    const bool able = std::any_of(classes.begin(), classes.end(),
                                  [&](const std::string& name) { return fits(name, needed, demand.isa); });
    if (able || classes.empty() || !contains_all(tags, demand.tags)) continue;
    LeftOut& group = left_out[classes.front()];
    group.workers += machines.workers;
    group.threads += machines.workers * threads;
  }
  return left_out;
}

}  // namespace tessera::server
