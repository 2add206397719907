// Complex indices of refraction of metals. Ag, Al, Au, Cu, MgO and TiO2 are the measurements that Luxpop
// collected and Mitsuba and pbrt-v4 carry; CuZn (brass, 70 % copper) is [Querry 1985].
#include "spectra/matter/metals.h"

#include <cstddef>
#include <iterator>
#include <span>

namespace tessera::spectra {
namespace {

// The metals' samples are evenly spaced in photon energy: 4.15 eV down to 1.4 eV in steps of 0.05 eV.
constexpr int kSamples = 56;
constexpr double kElectronVoltNm = 1239.84175;  // h c

constexpr std::string_view kLuxpop = "Luxpop, mostly of Palik 1985";

constexpr float kAgEta[] = {1.519f,    1.496f, 1.4325f,   1.323f, 1.142062f, 0.932f, 0.719062f, 0.526f,
                            0.388125f, 0.294f, 0.253313f, 0.238f, 0.221438f, 0.209f, 0.194813f, 0.186f,
                            0.192063f, 0.2f,   0.198063f, 0.192f, 0.182f,    0.173f, 0.172625f, 0.173f,
                            0.166688f, 0.16f,  0.1585f,   0.157f, 0.151063f, 0.144f, 0.137313f, 0.132f,
                            0.13025f,  0.13f,  0.129938f, 0.13f,  0.130063f, 0.129f, 0.124375f, 0.12f,
                            0.119313f, 0.121f, 0.1255f,   0.131f, 0.136125f, 0.14f,  0.140063f, 0.14f,
                            0.144313f, 0.148f, 0.145875f, 0.143f, 0.142563f, 0.145f, 0.151938f, 0.163f};
constexpr float kAgK[] = {1.08f,     0.882f, 0.761063f, 0.647f, 0.550875f, 0.504f, 0.554375f, 0.663f,
                          0.818563f, 0.986f, 1.120687f, 1.24f,  1.34525f,  1.44f,  1.53375f,  1.61f,
                          1.641875f, 1.67f,  1.735f,    1.81f,  1.87875f,  1.95f,  2.029375f, 2.11f,
                          2.18625f,  2.26f,  2.329375f, 2.4f,   2.47875f,  2.56f,  2.64f,     2.72f,
                          2.798125f, 2.88f,  2.97375f,  3.07f,  3.159375f, 3.25f,  3.348125f, 3.45f,
                          3.55375f,  3.66f,  3.76625f,  3.88f,  4.010625f, 4.15f,  4.293125f, 4.44f,
                          4.58625f,  4.74f,  4.908125f, 5.09f,  5.28875f,  5.5f,   5.720624f, 5.95f};

constexpr float kAlEta[] = {0.273375f, 0.28f,  0.286813f, 0.294f, 0.301875f, 0.31f,  0.317875f, 0.326f,
                            0.33475f,  0.344f, 0.353813f, 0.364f, 0.374375f, 0.385f, 0.39575f,  0.407f,
                            0.419125f, 0.432f, 0.445688f, 0.46f,  0.474688f, 0.49f,  0.506188f, 0.523f,
                            0.540063f, 0.558f, 0.577313f, 0.598f, 0.620313f, 0.644f, 0.668625f, 0.695f,
                            0.72375f,  0.755f, 0.789f,    0.826f, 0.867f,    0.912f, 0.963f,    1.02f,
                            1.08f,     1.15f,  1.22f,     1.3f,   1.39f,     1.49f,  1.6f,      1.74f,
                            1.91f,     2.14f,  2.41f,     2.63f,  2.8f,      2.74f,  2.58f,     2.24f};
constexpr float kAlK[] = {
    3.59375f, 3.64f, 3.689375f, 3.74f, 3.789375f, 3.84f, 3.894375f, 3.95f, 4.005f,    4.06f, 4.11375f,  4.17f,
    4.23375f, 4.3f,  4.365f,    4.43f, 4.49375f,  4.56f, 4.63375f,  4.71f, 4.784375f, 4.86f, 4.938125f, 5.02f,
    5.10875f, 5.2f,  5.29f,     5.38f, 5.48f,     5.58f, 5.69f,     5.8f,  5.915f,    6.03f, 6.15f,     6.28f,
    6.42f,    6.55f, 6.7f,      6.85f, 7.0f,      7.15f, 7.31f,     7.48f, 7.65f,     7.82f, 8.01f,     8.21f,
    8.39f,    8.57f, 8.62f,     8.6f,  8.45f,     8.31f, 8.21f,     8.21f};

constexpr float kAuEta[] = {1.795f,    1.812f, 1.822625f, 1.83f,  1.837125f, 1.84f,  1.83425f,  1.824f,
                            1.812f,    1.798f, 1.782f,    1.766f, 1.7525f,   1.74f,  1.727625f, 1.716f,
                            1.705875f, 1.696f, 1.68475f,  1.674f, 1.666f,    1.658f, 1.64725f,  1.636f,
                            1.628f,    1.616f, 1.59625f,  1.562f, 1.502125f, 1.426f, 1.345875f, 1.242f,
                            1.08675f,  0.916f, 0.7545f,   0.608f, 0.49175f,  0.402f, 0.3455f,   0.306f,
                            0.267625f, 0.236f, 0.212375f, 0.194f, 0.17775f,  0.166f, 0.161f,    0.16f,
                            0.160875f, 0.164f, 0.1695f,   0.176f, 0.181375f, 0.188f, 0.198125f, 0.21f};
constexpr float kAuK[] = {1.920375f, 1.92f,  1.918875f, 1.916f, 1.911375f, 1.904f, 1.891375f, 1.878f,
                          1.86825f,  1.86f,  1.85175f,  1.846f, 1.84525f,  1.848f, 1.852375f, 1.862f,
                          1.883f,    1.906f, 1.9225f,   1.936f, 1.94775f,  1.956f, 1.959375f, 1.958f,
                          1.951375f, 1.94f,  1.9245f,   1.904f, 1.875875f, 1.846f, 1.814625f, 1.796f,
                          1.797375f, 1.84f,  1.9565f,   2.12f,  2.32625f,  2.54f,  2.730625f, 2.88f,
                          2.940625f, 2.97f,  3.015f,    3.06f,  3.07f,     3.15f,  3.445812f, 3.8f,
                          4.087687f, 4.357f, 4.610188f, 4.86f,  5.125813f, 5.39f,  5.63125f,  5.88f};

constexpr float kCuEta[] = {1.400313f, 1.38f,  1.358438f, 1.34f,  1.329063f, 1.325f, 1.3325f,   1.34f,
                            1.334375f, 1.325f, 1.317812f, 1.31f,  1.300313f, 1.29f,  1.281563f, 1.27f,
                            1.249062f, 1.225f, 1.2f,      1.18f,  1.174375f, 1.175f, 1.1775f,   1.18f,
                            1.178125f, 1.175f, 1.172812f, 1.17f,  1.165312f, 1.16f,  1.155312f, 1.15f,
                            1.142812f, 1.135f, 1.131562f, 1.12f,  1.092437f, 1.04f,  0.950375f, 0.826f,
                            0.645875f, 0.468f, 0.35125f,  0.272f, 0.230813f, 0.214f, 0.20925f,  0.213f,
                            0.21625f,  0.223f, 0.2365f,   0.25f,  0.254188f, 0.26f,  0.28f,     0.3f};
constexpr float kCuK[] = {1.662125f, 1.687f, 1.703313f, 1.72f,  1.744563f, 1.77f,  1.791625f, 1.81f,
                          1.822125f, 1.834f, 1.85175f,  1.872f, 1.89425f,  1.916f, 1.931688f, 1.95f,
                          1.972438f, 2.015f, 2.121562f, 2.21f,  2.177188f, 2.13f,  2.160063f, 2.21f,
                          2.249938f, 2.289f, 2.326f,    2.362f, 2.397625f, 2.433f, 2.469187f, 2.504f,
                          2.535875f, 2.564f, 2.589625f, 2.605f, 2.595562f, 2.583f, 2.5765f,   2.599f,
                          2.678062f, 2.809f, 3.01075f,  3.24f,  3.458187f, 3.67f,  3.863125f, 4.05f,
                          4.239563f, 4.43f,  4.619563f, 4.817f, 5.034125f, 5.26f,  5.485625f, 5.717f};

static_assert(std::size(kAgEta) == kSamples && std::size(kAgK) == kSamples && std::size(kAlEta) == kSamples &&
              std::size(kAlK) == kSamples && std::size(kAuEta) == kSamples && std::size(kAuK) == kSamples &&
              std::size(kCuEta) == kSamples && std::size(kCuK) == kSamples);

constexpr float kCuZnNm[] = {260, 280, 300, 330, 360, 400, 450, 500, 530, 550, 600, 630, 650, 700, 800, 900};
constexpr float kCuZnEta[] = {1.51f,  1.46f,  1.47f, 1.48f,  1.45f,  1.445f, 1.094f, 0.686f,
                              0.573f, 0.527f, 0.45f, 0.445f, 0.444f, 0.446f, 0.473f, 0.523f};
constexpr float kCuZnK[] = {1.72f,  1.68f,  1.7f,   1.73f,  1.78f,  1.805f, 1.829f, 2.25f,
                            2.568f, 2.765f, 3.253f, 3.522f, 3.695f, 4.106f, 4.89f,  5.65f};

constexpr float kMgONm[] = {309.95f,  330.613f, 351.119f, 360.932f, 382.065f, 404.634f,
                            435.782f, 457.829f, 477.949f, 499.919f, 514.44f,  546.167f,
                            589.259f, 632.874f, 656.326f, 690.696f, 706.439f, 767.678f};
constexpr float kMgOEta[] = {1.798f,   1.785f,  1.7768f,  1.7732f,  1.7668f,  1.76104f,
                             1.75471f, 1.7512f, 1.7483f,  1.7454f,  1.7439f,  1.74077f,
                             1.73737f, 1.7346f, 1.73335f, 1.73191f, 1.73101f, 1.72872f};

constexpr float kTiO2Nm[] = {305.972f, 317.979f, 334.991f, 344.007f, 359.988f, 388.044f, 399.935f,
                             412.031f, 419.986f, 439.957f, 460.037f, 479.985f, 499.919f, 520.05f,
                             539.044f, 539.983f, 559.982f, 579.888f, 600.097f, 619.9f,   640.062f,
                             659.819f, 680.088f, 700.056f, 719.977f, 740.179f, 760.147f, 779.748f,
                             799.871f, 819.974f, 839.973f, 859.778f, 879.915f, 899.71f};
constexpr float kTiO2Eta[] = {3.84f, 5.38f, 4.22f, 4.36f, 3.87f, 3.49f, 3.4f,  3.24f, 3.29f,
                              3.2f,  3.13f, 3.08f, 3.03f, 3.0f,  2.95f, 2.97f, 2.94f, 2.92f,
                              2.9f,  2.88f, 2.87f, 2.85f, 2.84f, 2.83f, 2.82f, 2.81f, 2.81f,
                              2.8f,  2.79f, 2.79f, 2.78f, 2.78f, 2.77f, 2.77f};
constexpr float kTiO2K[] = {1.95f, 2.18f, 0.788f, 0, 0.251f, 0, 0, 0.022f, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                            0,     0,     0,      0, 0,      0, 0, 0,      0, 0, 0, 0, 0, 0, 0, 0, 0};

constexpr float kTransparent[] = {0, 0};

static_assert(std::size(kCuZnNm) == std::size(kCuZnEta) && std::size(kCuZnNm) == std::size(kCuZnK) &&
              std::size(kMgONm) == std::size(kMgOEta) && std::size(kTiO2Nm) == std::size(kTiO2Eta) &&
              std::size(kTiO2Nm) == std::size(kTiO2K));

// Transition metals [Johnson & Christy 1974], by way of refractiveindex.info.
constexpr std::size_t kTransitionSamples = 25;
using TransitionValues = float[kTransitionSamples];
constexpr TransitionValues kTransitionNm = {292, 301, 311, 320, 332, 342, 354, 368, 381, 397, 413, 431, 451,
                                            471, 496, 521, 549, 582, 617, 659, 704, 756, 821, 892, 984};
constexpr TransitionValues kCrEta = {1.48f, 1.53f, 1.58f, 1.65f, 1.69f, 1.76f, 1.84f, 1.87f, 1.92f,
                                     2,     2.08f, 2.19f, 2.33f, 2.51f, 2.75f, 2.94f, 3.18f, 3.22f,
                                     3.17f, 3.09f, 3.05f, 3.08f, 3.2f,  3.3f,  3.41f};
constexpr TransitionValues kCrK = {2.28f, 2.34f, 2.4f,  2.47f, 2.53f, 2.58f, 2.64f, 2.69f, 2.74f,
                                   2.83f, 2.93f, 3.04f, 3.14f, 3.24f, 3.3f,  3.33f, 3.33f, 3.3f,
                                   3.3f,  3.34f, 3.39f, 3.42f, 3.48f, 3.52f, 3.57f};
constexpr TransitionValues kFeEta = {1.65f, 1.67f, 1.69f, 1.74f, 1.78f, 1.85f, 1.93f, 2.02f, 2.12f,
                                     2.24f, 2.35f, 2.48f, 2.59f, 2.67f, 2.74f, 2.86f, 2.95f, 2.94f,
                                     2.88f, 2.92f, 2.86f, 2.87f, 2.94f, 2.96f, 2.92f};
constexpr TransitionValues kFeK = {1.94f, 2,     2.06f, 2.12f, 2.19f, 2.27f, 2.35f, 2.43f, 2.5f,
                                   2.58f, 2.65f, 2.71f, 2.77f, 2.82f, 2.88f, 2.91f, 2.93f, 2.99f,
                                   3.05f, 3.1f,  3.19f, 3.28f, 3.39f, 3.56f, 3.79f};
constexpr TransitionValues kNiEta = {2.03f, 2.02f, 2.01f, 1.93f, 1.84f, 1.78f, 1.74f, 1.7f,  1.72f,
                                     1.72f, 1.7f,  1.71f, 1.73f, 1.78f, 1.82f, 1.85f, 1.92f, 1.96f,
                                     1.99f, 1.99f, 2.06f, 2.13f, 2.26f, 2.4f,  2.48f};
constexpr TransitionValues kNiK = {2.2f,  2.18f, 2.18f, 2.19f, 2.22f, 2.26f, 2.32f, 2.4f,  2.48f,
                                   2.57f, 2.69f, 2.82f, 2.95f, 3.09f, 3.25f, 3.42f, 3.61f, 3.8f,
                                   4.02f, 4.26f, 4.5f,  4.73f, 4.97f, 5.23f, 5.55f};
constexpr TransitionValues kTiEta = {1.4f,  1.45f, 1.5f,  1.55f, 1.61f, 1.72f, 1.82f, 1.9f,  1.99f,
                                     2.08f, 2.14f, 2.21f, 2.27f, 2.32f, 2.36f, 2.44f, 2.54f, 2.6f,
                                     2.67f, 2.76f, 2.86f, 3,     3.21f, 3.29f, 3.35f};
constexpr TransitionValues kTiK = {2.36f, 2.46f, 2.57f, 2.66f, 2.74f, 2.82f, 2.87f, 2.9f,  2.93f,
                                   2.95f, 2.98f, 3.01f, 3.04f, 3.1f,  3.19f, 3.3f,  3.43f, 3.58f,
                                   3.72f, 3.84f, 3.96f, 4.01f, 4.01f, 3.96f, 3.97f};

Curve energy_curve(std::span<const float> values) {
  Curve curve;
  for (int i = 0; i < kSamples; ++i) {
    curve.nm.push_back(static_cast<float>(kElectronVoltNm / (4.15 - 0.05 * i)));
    curve.values.push_back(values[static_cast<std::size_t>(i)]);
  }
  return curve;
}

Curve curve_of(std::span<const float> nm, std::span<const float> values) {
  return {{nm.begin(), nm.end()}, {values.begin(), values.end()}};
}

Metal luxpop(std::span<const float> eta, std::span<const float> k) {
  return {energy_curve(eta), energy_curve(k), kLuxpop};
}

Metal transition_metal(const TransitionValues& eta, const TransitionValues& k) {
  return {curve_of(kTransitionNm, eta), curve_of(kTransitionNm, k), "Johnson and Christy 1974"};
}

}  // namespace

std::optional<Metal> find_metal(std::string_view name) {
  if (name == "Ag") return luxpop(kAgEta, kAgK);
  if (name == "Al") return luxpop(kAlEta, kAlK);
  if (name == "Au") return luxpop(kAuEta, kAuK);
  if (name == "Cr") return transition_metal(kCrEta, kCrK);
  if (name == "Cu") return luxpop(kCuEta, kCuK);
  if (name == "CuZn") return Metal{curve_of(kCuZnNm, kCuZnEta), curve_of(kCuZnNm, kCuZnK), "Querry 1985"};
  if (name == "Fe") return transition_metal(kFeEta, kFeK);
  // Magnesium oxide is transparent: its extinction is below 1e-6 everywhere.
  if (name == "MgO") return Metal{curve_of(kMgONm, kMgOEta), uniform_curve(300, 500, kTransparent), kLuxpop};
  if (name == "Ni") return transition_metal(kNiEta, kNiK);
  if (name == "Ti") return transition_metal(kTiEta, kTiK);
  if (name == "TiO2") return Metal{curve_of(kTiO2Nm, kTiO2Eta), curve_of(kTiO2Nm, kTiO2K), kLuxpop};
  return std::nullopt;
}

double normal_reflectance(double eta, double k) {
  const double low = (eta - 1) * (eta - 1) + k * k, high = (eta + 1) * (eta + 1) + k * k;
  return low / high;
}

}  // namespace tessera::spectra
