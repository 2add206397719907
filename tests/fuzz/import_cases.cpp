#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() {
  return {{&kPly, 200'000},    {&kObj, 100'000}, {&kSerialized, 100'000}, {&kVolumeFile, 100'000},
          {&kMitsuba, 25'000}, {&kPbrt, 5'000},  {&kGltf, 40'000},        {&kTextScene, 4'000},
          {&kLens, 800},       {&kExr, 60}};
}

}  // namespace tessera::fuzz
