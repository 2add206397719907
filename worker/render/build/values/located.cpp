#include "render/build/values/located.h"

#include "absl/strings/str_cat.h"

namespace tessera::render {

std::string place_in_scene(const char* what, int index, const std::string& name) {
  return name.empty() ? absl::StrCat(what, " ", index) : absl::StrCat(what, " ", index, " (", name, ")");
}

absl::Status located(const absl::Status& status, const std::string& where) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(where, ": ", status.message()));
}

}  // namespace tessera::render
