#include "render/scene/values/located.h"

#include "absl/strings/str_cat.h"

namespace tessera::render {

absl::Status located(const absl::Status& status, const std::string& where) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(where, ": ", status.message()));
}

}  // namespace tessera::render
