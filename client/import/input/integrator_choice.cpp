#include "import/input/integrator_choice.h"

#include <algorithm>

#include "import/input/concat.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/film_sensor.h"

namespace tessera::client {
namespace {

/// Why our algorithm does not render the scene; empty: it does.
std::string hindrance(const IntegratorName& asked, const v1::Scene& scene) {
  if (wire::find_algorithm(asked.ours) == nullptr) return "does not exist here";
  v1::Algorithms algorithms;
  algorithms.set_integrator(std::string(asked.ours));
  algorithms.set_color(scene.settings().color());
  v1::JobSpec::View view;
  view.set_film(scene.settings().film());
  if (wire::bands_of(view).count > 0) algorithms.set_color(v1::COLOR_SPECTRAL);
  return wire::obstacle_to(algorithms, scene, asked.sees_media);
}

}  // namespace

std::optional<IntegratorName> find_integrator(std::span<const IntegratorName> names,
                                              std::string_view theirs) {
  const auto known = std::ranges::find(names, theirs, &IntegratorName::theirs);
  if (known != names.end()) return *known;
  if (theirs.empty() || wire::find_algorithm(theirs) == nullptr) return std::nullopt;
  return IntegratorName{theirs, theirs, theirs};
}

std::string list_of(std::span<const IntegratorName> names) {
  std::string list;
  for (const IntegratorName& name : names) list = concat(list, list.empty() ? "" : ", ", name.theirs);
  return list;
}

IntegratorChoice choose_integrator(const IntegratorName& asked, const v1::Scene& scene) {
  if (asked.ours == asked.stand_in) return {std::string(asked.ours), ""};
  const std::string why = hindrance(asked, scene);
  if (why.empty()) return {std::string(asked.ours), ""};
  return {std::string(asked.stand_in),
          concat("integrator \"", asked.theirs, "\" is '", asked.ours, "', which ", why, ": '",
                 asked.stand_in, "' renders the scene")};
}

}  // namespace tessera::client
