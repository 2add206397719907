#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() {
  return {{&kUpload, 10'000},  {&kWebRequest, 10'000}, {&kJournal, 1'000},
          {&kSceneBuild, 300}, {&kCsg, 5'000},         {&kNoisePilot, 5'000}};
}

}  // namespace tessera::fuzz
