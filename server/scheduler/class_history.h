// The arithmetic classes that the results of one job were made in.
#pragma once

#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera::server {

/// Results are of the class that the job is bound to, but for those of which something else is noted: a host
/// stays with its class, so notes are few.
class ClassHistory {
 public:
  explicit ClassHistory(std::string bound = "") : bound_(std::move(bound)) {}

  /// Empty when the job is bound to none, or to none yet.
  const std::string& bound() const { return bound_; }
  void bind(std::string name) { bound_ = std::move(name); }

  /// The class of the host's result of that number.
  const std::string& of(const std::string& host, std::uint32_t sequence) const {
    const auto notes = classes_by_host_.find(host);
    if (notes == classes_by_host_.end()) return bound_;
    const auto after = notes->second.upper_bound(sequence);
    return after == notes->second.begin() ? bound_ : std::prev(after)->second;
  }

  /// From that number on, the host's results are of the class. False when that is known already.
  bool note(const std::string& host, std::uint32_t sequence, const std::string& name) {
    if (of(host, sequence) == name) return false;
    classes_by_host_[host][sequence] = name;
    noted_.insert(name);
    return true;
  }

  /// Each class once, that of the bound first, the others by name.
  std::vector<std::string> all() const;

 private:
  std::string bound_;
  std::map<std::string, std::map<std::uint32_t, std::string>>
      classes_by_host_;          // host -> number of the first result in the class -> class
  std::set<std::string> noted_;  // the classes in `classes_by_host_`, each once
};

/// The kernel ISAs of classes, each once: "avx512+avx2".
std::string isas_of(const std::vector<std::string>& classes);

}  // namespace tessera::server
