#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() {
  return {{&kTileResult, 20'000}, {&kMeshBlob, 50'000}, {&kVolumeBlob, 50'000}, {&kImage, 3'000},
          {&kUpload, 10'000},     {&kJournal, 1'000},   {&kSceneBuild, 1'000}};
}

}  // namespace tessera::fuzz
