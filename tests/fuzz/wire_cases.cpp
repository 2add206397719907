#include "fuzz/cases.h"

namespace tessera::fuzz {

std::vector<Case> cases() {
  return {{&kTileResult, 20'000}, {&kMeshBlob, 50'000},   {&kVolumeBlob, 50'000}, {&kImage, 500},
          {&kLayers, 3000},       {&kExpression, 20'000}, {&kPhaseBlob, 50'000},  {&kPackedInstances, 50'000},
          {&kWeather, 2000},      {&kLamp, 20'000}};
}

}  // namespace tessera::fuzz
