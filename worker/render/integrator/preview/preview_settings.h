// Settings of `preview` as the kernels read them.
#pragma once

#include <cstdint>

namespace tessera::render {

enum class ShadowKind : std::uint8_t {
  kNone,
  kHard,      // one texel of a shadow map
  kFiltered,  // the share of texels about it that are lit: percentage-closer filtering
  kSoft       // the same, over as much as the lamp's size asks for
};

struct PreviewSettings {
  ShadowKind shadows = ShadowKind::kSoft;
  float ambient = 1;  // factor of ambient light
};

}  // namespace tessera::render
