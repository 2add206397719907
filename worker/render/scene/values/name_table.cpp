#include "render/scene/values/name_table.h"

#include "absl/strings/str_cat.h"

namespace tessera::render {

absl::Status NameTable::add(const std::string& name, int index) {
  if (indices_.emplace(name, index).second) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(kind_, " '", name, "': the name is used twice"));
}

absl::StatusOr<int> NameTable::find(const std::string& name) const {
  if (name.empty() && unnamed_) return *unnamed_;
  const auto it = indices_.find(name);
  if (it != indices_.end()) return it->second;
  return absl::InvalidArgumentError(absl::StrCat(kind_, " '", name, "' does not exist"));
}

}  // namespace tessera::render
