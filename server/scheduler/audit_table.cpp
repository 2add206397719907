#include "scheduler/audit_table.h"

#include <iterator>

namespace tessera::server {

const Audit* AuditTable::find(std::uint32_t unit) const {
  const auto found = audits_.find(unit);
  return found == audits_.end() ? nullptr : &found->second;
}

void AuditTable::put(std::uint32_t unit, Audit audit) {
  audits_[unit] = std::move(audit);
  waiting_.insert(unit);
}

void AuditTable::erase(std::uint32_t unit) {
  audits_.erase(unit);
  waiting_.erase(unit);
}

void AuditTable::erase_if(const std::function<bool(std::uint32_t, const Audit&)>& is_meant) {
  for (auto it = audits_.begin(); it != audits_.end();) {
    const auto next = std::next(it);
    if (is_meant(it->first, it->second)) erase(it->first);
    it = next;
  }
}

void AuditTable::clear() {
  audits_.clear();
  waiting_.clear();
}

void AuditTable::add_opinion(std::uint32_t unit, const std::string& host, ResultFingerprint result) {
  audits_.at(unit).opinions.emplace_back(host, result);
}

void AuditTable::take(std::uint32_t unit) { waiting_.erase(unit); }

void AuditTable::give_back(std::uint32_t unit) {
  const auto found = audits_.find(unit);
  if (found == audits_.end()) return;
  found->second.lost = true;
  waiting_.insert(unit);
}

void AuditTable::drop_opinions(const std::function<bool(const std::string& host)>& is_meant) {
  for (auto& [unit, audit] : audits_)
    std::erase_if(audit.opinions, [&](const auto& opinion) { return is_meant(opinion.first); });
}

}  // namespace tessera::server
