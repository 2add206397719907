// Layers as clients ask for them: a list of light path expressions.
#include "fuzz/target.h"
#include "layers/automaton.h"

namespace tessera::fuzz {
namespace {

bool accepts_layers(std::string_view bytes) {
  const auto asked = layers::parse_layers(std::string(bytes));
  const absl::Status checked = asked.ok() ? layers::check_layers(*asked) : asked.status();
  if (!checked.ok()) {
    require(!checked.message().empty(), "an error without a message");
    return false;
  }
  const layers::Alphabet named = {.surfaces = {{}, {layers::names_in(*asked), {}}}};
  for (const auto direction : {layers::Direction::kFromCamera, layers::Direction::kFromLights}) {
    const auto automaton = layers::compile(*asked, named, direction);
    if (!automaton.ok()) continue;  // it may be larger with these names
    for (const std::int32_t next : automaton->next)
      require(next >= 0 && next < automaton->states, "a step to a state that is not there");
    for (const std::int32_t found : automaton->layers) {
      require(asked->size() == layers::kMaxLayers || static_cast<std::uint32_t>(found) >> asked->size() == 0,
              "a layer that was not asked for");
    }
  }
  return true;
}

}  // namespace

const Target kLayers = {"layers", accepts_layers};

}  // namespace tessera::fuzz
