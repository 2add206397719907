#include "photometry/sky/perez_sky.h"

#include <algorithm>
#include <cmath>

#include "photometry/sun/sun_irradiance.h"

namespace tessera::photometry {
namespace {

constexpr int kClasses = 8;
constexpr double kClassEnds[kClasses - 1] = {1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2};

int class_of(double clearness) {
  return static_cast<int>(std::ranges::upper_bound(kClassEnds, clearness) - kClassEnds);
}

/// x = x1 + x2 Z + Delta (x3 + x4 Z)
struct Fit {
  double x1, x2, x3, x4;
  double at(double zenith, double brightness) const {
    return x1 + x2 * zenith + brightness * (x3 + x4 * zenith);
  }
};
struct Class {
  Fit a, b, c, d, e;
};

// [Perez1993, table 1]
constexpr Class kPatterns[kClasses] = {
    {{1.3525, -0.2576, -0.2690, -1.4366},
     {-0.7670, 0.0007, 1.2734, -0.1233},
     {2.8000, 0.6004, 1.2375, 1.0000},
     {1.8734, 0.6297, 0.9738, 0.2809},
     {0.0356, -0.1246, -0.5718, 0.9938}},
    {{-1.2219, -0.7730, 1.4148, 1.1016},
     {-0.2054, 0.0367, -3.9128, 0.9156},
     {6.9750, 0.1774, 6.4477, -0.1239},
     {-1.5798, -0.5081, -1.7812, 0.1080},
     {0.2624, 0.0672, -0.2190, -0.4285}},
    {{-1.1000, -0.2515, 0.8952, 0.0156},
     {0.2782, -0.1812, -4.5000, 1.1766},
     {24.7219, -13.0812, -37.7000, 34.8438},
     {-5.0000, 1.5218, 3.9229, -2.6204},
     {-0.0156, 0.1597, 0.4199, -0.5562}},
    {{-0.5484, -0.6654, -0.2672, 0.7117},
     {0.7234, -0.6219, -5.6812, 2.6297},
     {33.3389, -18.3000, -62.2500, 52.0781},
     {-3.5000, 0.0016, 1.1477, 0.1062},
     {0.4659, -0.3296, -0.0876, -0.0329}},
    {{-0.6000, -0.3566, -2.5000, 2.3250},
     {0.2937, 0.0496, -5.6812, 1.8415},
     {21.0000, -4.7656, -21.5906, 7.2492},
     {-3.5000, -0.1554, 1.4062, 0.3988},
     {0.0032, 0.0766, -0.0656, -0.1294}},
    {{-1.0156, -0.3670, 1.0078, 1.4051},
     {0.2875, -0.5328, -3.8500, 3.3750},
     {14.0000, -0.9999, -7.1406, 7.5469},
     {-3.4000, -0.1078, -1.0750, 1.5702},
     {-0.0672, 0.4016, 0.3017, -0.4844}},
    {{-1.0000, 0.0211, 0.5025, -0.5119},
     {-0.3000, 0.1922, 0.7023, -1.6317},
     {19.0000, -5.0000, 1.2438, -1.9094},
     {-4.0000, 0.0250, 0.3844, 0.2656},
     {1.0468, -0.3788, -2.4517, 1.4656}},
    {{-1.0500, 0.0289, 0.4260, 0.3590},
     {-0.3250, 0.1156, 0.7781, 0.0025},
     {31.0625, -14.5000, -46.1148, 55.3750},
     {-7.2312, 0.4050, 13.3500, 0.6234},
     {1.5000, -0.6426, 1.8564, 0.5636}},
};

/// lm/W
struct Efficacy {
  double a, b, c, d;
};
// [Perez1990, table 4]: a + b W + c cos Z + d ln Delta
constexpr Efficacy kSkyEfficacies[kClasses] = {
    {97.24, -0.46, 12.00, -8.91},   {107.22, 1.15, 0.59, -3.95},    {104.97, 2.96, -5.53, -8.77},
    {102.39, 5.59, -13.95, -13.90}, {100.71, 5.94, -22.75, -23.74}, {106.42, 3.83, -36.15, -28.83},
    {141.88, 1.90, -53.24, -14.03}, {152.23, 0.35, -45.27, -7.98},
};
// a + b W + c exp(5.73 Z - 5) + d Delta
constexpr Efficacy kSunEfficacies[kClasses] = {
    {57.20, -4.55, -2.98, 117.12}, {98.99, -3.46, -1.21, 12.38},  {109.83, -4.90, -1.71, -8.81},
    {110.34, -5.84, -1.99, -4.56}, {106.36, -3.97, -1.75, -6.16}, {107.19, -1.25, -1.51, -26.73},
    {105.75, 0.77, -1.26, -34.44}, {101.18, 1.58, -1.10, -8.29},
};

constexpr double kLeastBrightness = 0.01, kMostBrightness = 0.6;

}  // namespace

PerezWeather perez_weather(const Irradiances& measured, double sun_zenith, double outside) {
  const double diffuse = measured.diffuse_horizontal;
  const double cube = 1.041 * sun_zenith * sun_zenith * sun_zenith;
  PerezWeather weather;
  weather.clearness = diffuse > 0 ? ((diffuse + measured.direct_normal) / diffuse + cube) / (1 + cube)
                                  : kClassEnds[kClasses - 2];
  weather.brightness = diffuse * relative_air_mass(90 - sun_zenith / kRadiansPerDegree) / outside;
  return weather;
}

SkyPattern perez_pattern(const PerezWeather& weather, double sun_zenith) {
  const int index = class_of(weather.clearness);
  const Class& fit = kPatterns[index];
  double brightness = std::clamp(weather.brightness, kLeastBrightness, kMostBrightness);
  if (weather.clearness > 1.065 && weather.clearness < 2.8) brightness = std::max(brightness, 0.2);
  SkyPattern pattern;
  pattern.a = fit.a.at(sun_zenith, brightness);
  pattern.b = std::min(fit.b.at(sun_zenith, brightness), 0.0);
  pattern.e = fit.e.at(sun_zenith, brightness);
  if (index > 0) {
    pattern.c = fit.c.at(sun_zenith, brightness);
    pattern.d = fit.d.at(sun_zenith, brightness);
  } else {
    // The class of overcast skies has forms of its own.
    pattern.c = std::exp(std::pow(brightness * (fit.c.x1 + fit.c.x2 * sun_zenith), fit.c.x3)) - fit.c.x4;
    pattern.d = -std::exp(brightness * (fit.d.x1 + fit.d.x2 * sun_zenith)) + fit.d.x3 + brightness * fit.d.x4;
  }
  return pattern;
}

Daylight perez_daylight(const Irradiances& measured, const PerezWeather& weather, double sun_zenith,
                        double dew_point_celsius) {
  const int index = class_of(weather.clearness);
  const double water = std::exp(0.07 * dew_point_celsius - 0.075);  // of the air above, cm
  const double brightness = std::clamp(weather.brightness, kLeastBrightness, kMostBrightness);
  const Efficacy &sky = kSkyEfficacies[index], &sun = kSunEfficacies[index];
  const double sky_efficacy =
      sky.a + sky.b * water + sky.c * std::cos(sun_zenith) + sky.d * std::log(brightness);
  const double sun_efficacy =
      sun.a + sun.b * water + sun.c * std::exp(5.73 * sun_zenith - 5) + sun.d * brightness;
  return {.diffuse_horizontal = measured.diffuse_horizontal * std::max(sky_efficacy, 0.0),
          .sun_normal = measured.direct_normal * std::max(sun_efficacy, 0.0)};
}

}  // namespace tessera::photometry
