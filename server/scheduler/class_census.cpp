#include "scheduler/class_census.h"

#include <algorithm>

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

/// Workers that a class has to offer.
struct Offer {
  std::vector<std::pair<std::uint32_t, std::uint64_t>>
      workers;                // threads of each, and how many such workers there are
  std::uint64_t dislike = 0;  // threads, each times the place of the class among those of its worker

  /// Threads of at most so many workers.
  std::uint64_t threads(std::uint32_t max_workers) {
    std::sort(workers.rbegin(), workers.rend());
    std::uint64_t sum = 0, left = max_workers == 0 ? UINT64_MAX : max_workers;
    for (const auto& [threads, count] : workers) {
      const std::uint64_t taken = std::min(left, count);
      sum += taken * threads;
      left -= taken;
    }
    return sum;
  }
};

}  // namespace

bool has_tags(const WorkerInfo& worker, const std::vector<std::string>& required) {
  return contains_all(worker.tags, required);
}

void ClassCensus::add(const WorkerInfo& worker) {
  ++workers_[{worker.classes, worker.tags, worker.threads}];
  ++revision_;
}

void ClassCensus::remove(const WorkerInfo& worker) {
  const auto kind = workers_.find({worker.classes, worker.tags, worker.threads});
  if (--kind->second == 0) workers_.erase(kind);
  ++revision_;
}

bool ClassCensus::has(const std::vector<std::string>& classes) const {
  const auto kind = workers_.lower_bound({classes, {}, 0});
  return kind != workers_.end() && std::get<0>(kind->first) == classes;
}

std::string ClassCensus::best(const Demand& demand) const {
  std::map<std::string, Offer> offers;
  for (const auto& [kind, count] : workers_) {
    const auto& [classes, tags, threads] = kind;
    if (!contains_all(tags, demand.tags)) continue;
    for (std::size_t place = 0; place < classes.size(); ++place) {
      if (!fits(classes[place], "", demand.isa)) continue;
      Offer& offer = offers[classes[place]];
      offer.workers.emplace_back(threads, count);
      offer.dislike += place * threads * count;
    }
  }
  const auto rank = [&](auto& entry) {
    return std::pair{entry.second.threads(demand.max_workers), ~entry.second.dislike};
  };
  const auto best =
      std::max_element(offers.begin(), offers.end(), [&](auto& a, auto& b) { return rank(a) < rank(b); });
  return best == offers.end() ? "" : best->first;
}

std::map<std::string, ClassCensus::LeftOut> ClassCensus::without(const std::string& needed,
                                                                 const Demand& demand) const {
  std::map<std::string, LeftOut> left_out;
  for (const auto& [kind, count] : workers_) {
    const auto& [classes, tags, threads] = kind;
    const bool able = std::any_of(classes.begin(), classes.end(),
                                  [&](const std::string& name) { return fits(name, needed, demand.isa); });
    if (able || classes.empty() || !contains_all(tags, demand.tags)) continue;
    LeftOut& group = left_out[classes.front()];
    group.workers += count;
    group.threads += count * threads;
  }
  return left_out;
}

}  // namespace tessera::server
