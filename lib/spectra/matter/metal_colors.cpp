#include "spectra/matter/metal_colors.h"

#include <algorithm>
#include <iterator>

namespace tessera::spectra {
namespace {

struct ColorEntry {
  std::string_view name;
  float eta[3], k[3];
};

// Linear Rec.709 under a light of equal energy. The measurements are those that Luxpop collected (mostly of
// [Palik 1985]) and Mitsuba carries; the colours are the ones that Tungsten's table of complex indices has,
// which were integrated as mitsuba_rgb() does it (named_spectra_test.cpp holds the metals that are here as
// spectra, and tungsten, against it).
constexpr ColorEntry kEntries[] = {
    {"a-C", {2.9441f, 2.2272f, 1.9682f}, {0.88743f, 0.79932f, 0.81529f}},
    {"AlAs", {3.6051f, 3.2329f, 2.2176f}, {0.00066702f, -0.00049994f, 0.0074261f}},
    {"AlSb", {-0.048523f, 4.1428f, 4.6698f}, {-0.036374f, 0.093767f, 1.3007f}},
    {"Be", {4.1851f, 3.1851f, 2.7841f}, {3.8354f, 3.0101f, 2.869f}},
    {"Cr", {4.3697f, 2.9167f, 1.6547f}, {5.2064f, 4.2314f, 3.7549f}},
    {"CsI", {2.1449f, 1.7023f, 1.6624f}, {0.0f, 0.0f, 0.0f}},
    {"Cu2O", {3.5493f, 2.9521f, 2.7369f}, {0.11322f, 0.19467f, 0.60017f}},
    {"CuO", {3.2454f, 2.4496f, 2.1974f}, {0.52027f, 0.57074f, 0.71723f}},
    {"d-C", {2.7113f, 2.3186f, 2.2289f}, {0.0f, 0.0f, 0.0f}},
    {"Hg", {2.3989f, 1.44f, 0.90955f}, {6.3276f, 4.3719f, 3.4218f}},
    {"HgTe", {4.7795f, 3.231f, 2.66f}, {1.632f, 1.5808f, 1.7296f}},
    {"Ir", {3.0864f, 2.0822f, 1.6179f}, {5.5922f, 4.0672f, 3.2673f}},
    {"K", {0.064049f, 0.04641f, 0.038184f}, {2.1042f, 1.3489f, 0.91321f}},
    {"Li", {0.26579f, 0.19561f, 0.22092f}, {3.5402f, 2.3111f, 1.6686f}},
    {"Mo", {4.4837f, 3.5255f, 2.7761f}, {4.1111f, 3.4209f, 3.1506f}},
    {"Na_palik", {0.060267f, 0.056141f, 0.061991f}, {3.1793f, 2.1125f, 1.5791f}},
    {"Nb", {3.4201f, 2.7902f, 2.3956f}, {3.4414f, 2.7376f, 2.5799f}},
    {"Ni_palik", {2.3673f, 1.6634f, 1.4671f}, {4.4988f, 3.0502f, 2.3454f}},
    {"Rh", {2.5858f, 1.8602f, 1.5544f}, {6.7823f, 4.703f, 3.9761f}},
    {"Se", {4.0593f, 2.8427f, 2.8208f}, {0.75438f, 0.63852f, 0.52159f}},
    {"Se-e", {5.7243f, 4.1654f, 4.0816f}, {0.87137f, 1.1053f, 1.5648f}},
    {"SiC", {3.1723f, 2.526f, 2.4794f}, {7.284e-07f, -6.859e-07f, 1.0015e-05f}},
    {"SnTe", {4.5252f, 1.9812f, 1.2817f}, {0.0f, 0.0f, 0.0f}},
    {"Ta", {2.0626f, 2.3931f, 2.6281f}, {2.408f, 1.7414f, 1.947f}},
    {"Te", {7.3908f, 4.4821f, 2.6371f}, {3.2561f, 3.5274f, 3.2922f}},
    {"Te-e", {7.509f, 4.2965f, 2.3699f}, {5.5842f, 4.9476f, 3.9975f}},
    {"ThF4", {1.8307f, 1.4422f, 1.3876f}, {0.0f, 0.0f, 0.0f}},
    {"TiC", {3.7005f, 2.8374f, 2.5823f}, {3.2657f, 2.3516f, 2.1728f}},
    {"TiN", {1.6485f, 1.1504f, 1.3798f}, {3.3685f, 1.9435f, 1.102f}},
    {"TiO2-e", {3.1066f, 2.5132f, 2.5824f}, {2.8954e-05f, -2.5148e-05f, 0.00017756f}},
    {"VC", {3.6576f, 2.7527f, 2.5327f}, {3.0684f, 2.1987f, 1.9632f}},
    {"VN", {2.8656f, 2.1192f, 1.9401f}, {3.0323f, 2.0561f, 1.6163f}},
    {"V_palik", {4.2775f, 3.5132f, 2.7611f}, {3.4912f, 2.8894f, 3.1117f}},
    {"W", {4.3707f, 3.3003f, 2.9983f}, {3.5007f, 2.6049f, 2.2732f}},
};

std::array<double, 3> color_of(const float (&rgb)[3]) {
  // Colours outside of the gamut are below 0 in a component.
  return {std::max(0.0, double{rgb[0]}), std::max(0.0, double{rgb[1]}), std::max(0.0, double{rgb[2]})};
}

}  // namespace

std::optional<MetalColor> find_metal_color(std::string_view name) {
  for (const ColorEntry& entry : kEntries) {
    if (entry.name == name) return MetalColor{color_of(entry.eta), color_of(entry.k)};
  }
  return std::nullopt;
}

std::vector<std::string> metal_color_names() {
  std::vector<std::string> names;
  for (const ColorEntry& entry : kEntries) names.emplace_back(entry.name);
  return names;
}

}  // namespace tessera::spectra
