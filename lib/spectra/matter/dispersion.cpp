// Coefficients by way of refractiveindex.info, whose database is in the public domain (CC0).
#include "spectra/matter/dispersion.h"

#include <algorithm>
#include <cmath>

namespace tessera::spectra {
namespace {

constexpr auto kSellmeier = Dispersion::Formula::kSellmeier;
constexpr auto kCauchy = Dispersion::Formula::kCauchy;
constexpr std::string_view kSchott = "Schott, catalogue of 2017-01-20";

/// Formulas that were fitted to nothing hold within the wavelengths of visible light and a little beyond.
constexpr double kLeastNm = 300, kMostNm = 1000;

constexpr double sqr_um(double um) { return um * um; }

constexpr Dispersion kDispersions[] = {
    {"N-BK7",
     kSellmeier,
     {{{1.03961212, 0.00600069867}, {0.231792344, 0.0200179144}, {1.01046945, 103.560653}}},
     300,
     2500,
     kSchott},
    {"N-BAF10",
     kSellmeier,
     {{{1.5851495, 0.00926681282}, {0.143559385, 0.0424489805}, {1.08521269, 105.613573}}},
     350,
     2500,
     kSchott},
    {"N-FK51A",
     kSellmeier,
     {{{0.971247817, 0.00472301995}, {0.216901417, 0.0153575612}, {0.904651666, 168.68133}}},
     290,
     2500,
     kSchott},
    {"N-LASF9",
     kSellmeier,
     {{{2.00029547, 0.0121426017}, {0.298926886, 0.0538736236}, {1.80691843, 156.530829}}},
     365,
     2500,
     kSchott},
    {"N-SF11",
     kSellmeier,
     {{{1.73759695, 0.013188707}, {0.313747346, 0.0623068142}, {1.89878101, 155.23629}}},
     370,
     2500,
     kSchott},
    {"F2",
     kSellmeier,
     {{{1.34533359, 0.00997743871}, {0.209073176, 0.0470450767}, {0.937357162, 111.886764}}},
     320,
     2500,
     kSchott},
    {"F5",
     kSellmeier,
     {{{1.3104463, 0.00958633048}, {0.19603426, 0.0457627627}, {0.96612977, 115.011883}}},
     320,
     2500,
     kSchott},
    {"SF5",
     kSellmeier,
     {{{1.46141885, 0.0111826126}, {0.247713019, 0.0508594669}, {0.949995832, 112.041888}}},
     350,
     2500,
     kSchott},
    {"SF10",
     kSellmeier,
     {{{1.61625977, 0.0127534559}, {0.259229334, 0.0581983954}, {1.07762317, 116.60768}}},
     380,
     2500,
     kSchott},
    {"SF11",
     kSellmeier,
     {{{1.73848403, 0.0136068604}, {0.311168974, 0.0615960463}, {1.17490871, 121.922711}}},
     390,
     2500,
     kSchott},
    {"fused silica",
     kSellmeier,
     {{{0.6961663, sqr_um(0.0684043)}, {0.4079426, sqr_um(0.1162414)}, {0.8974794, sqr_um(9.896161)}}},
     210,
     6700,
     "Malitson 1965"},
    {"sapphire",
     kSellmeier,
     {{{1.4313493, sqr_um(0.0726631)}, {0.65054713, sqr_um(0.1193242)}, {5.3414021, sqr_um(18.028251)}}},
     200,
     5000,
     "Malitson and Dodge 1972"},
    {"diamond", kSellmeier, {{{0.3306, sqr_um(0.1750)}, {4.3356, sqr_um(0.1060)}}}, 226, 760, "Peter 1923"},
    {"water",
     kSellmeier,
     {{{5.684027565e-1, 5.101829712e-3},
       {1.726177391e-1, 1.821153936e-2},
       {2.086189578e-2, 2.620722293e-2},
       {1.130748688e-1, 1.069792721e1}}},
     182,
     1129,
     "Daimon and Masumura 2007, at 20 C"},
    {"ethanol",
     kCauchy,
     {{{1.35265, 0}, {0.00306, 2}, {0.00002, 4}}},
     476.5,
     830,
     "Rheims, Koser and Wriedt 1997, at 20 C"},
};

}  // namespace

double Dispersion::eta(double nm) const {
  const double um = std::clamp(nm, first_nm, last_nm) / 1000;
  double sum = formula == Formula::kSellmeier ? 1 : 0;
  for (const Term& term : terms) {
    if (formula == Formula::kCauchy)
      sum += term.b * std::pow(um, -term.c);
    else
      sum += term.b * um * um / (um * um - term.c);
  }
  return formula == Formula::kSellmeier ? std::sqrt(sum) : sum;
}

std::vector<std::string> dispersion_names() {
  std::vector<std::string> names;
  for (const Dispersion& dispersion : kDispersions) names.emplace_back(dispersion.name);
  return names;
}

Dispersion cauchy_dispersion(double b, double c, double d) {
  return {.name = {},
          .formula = Dispersion::Formula::kCauchy,
          .terms = {{{b, 0}, {c, 2}, {d, 4}}},
          .first_nm = kLeastNm,
          .last_nm = kMostNm,
          .source = {}};
}

Dispersion abbe_dispersion(double n_d, double abbe_number) {
  constexpr double kD = 0.58756, kF = 0.48613, kC = 0.65627;  // micrometres
  const double c = (n_d - 1) / abbe_number / (1 / (kF * kF) - 1 / (kC * kC));
  return cauchy_dispersion(n_d - c / (kD * kD), c, 0);
}

std::optional<Dispersion> find_dispersion(std::string_view name) {
  for (const Dispersion& dispersion : kDispersions) {
    if (name == dispersion.name) return dispersion;
  }
  return std::nullopt;
}

}  // namespace tessera::spectra
