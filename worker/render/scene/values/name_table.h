// Elements of a scene by their names.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace tessera::render {

class NameTable {
 public:
  /// Messages call an element `kind` ("material"). The empty name stands for `unnamed`, if that is given.
  explicit NameTable(const char* kind, std::optional<int> unnamed = std::nullopt)
      : kind_(kind), unnamed_(unnamed) {}

  /// InvalidArgument where the name is used already.
  absl::Status add(const std::string& name, int index);
  /// InvalidArgument where there is no element of this name.
  absl::StatusOr<int> find(const std::string& name) const;
  const std::map<std::string, int>& indices() const { return indices_; }

 private:
  const char* kind_;
  std::optional<int> unnamed_;
  std::map<std::string, int> indices_;
};

}  // namespace tessera::render
