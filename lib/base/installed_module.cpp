#include "base/installed_module.h"

#include <dlfcn.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::base {

absl::StatusOr<void*> installed_module(const char* file, const char* entry, std::string_view what) {
  void* const module = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
  void* const symbol = module == nullptr ? nullptr : dlsym(module, entry);
  if (symbol != nullptr) return symbol;
  return absl::FailedPreconditionError(absl::StrCat(std::string(what), ": ", dlerror(), " (", file,
                                                    " belongs into the folder lib beside bin)"));
}

}  // namespace tessera::base
