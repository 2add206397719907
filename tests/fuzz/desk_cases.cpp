#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() { return {{&kConfig, 10'000}, {&kDenoise, 200}}; }

}  // namespace tessera::fuzz
