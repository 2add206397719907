#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() { return {{&kUpload, 10'000}, {&kJournal, 1'000}, {&kSceneBuild, 300}}; }

}  // namespace tessera::fuzz
