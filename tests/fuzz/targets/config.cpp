// The user's configuration file: read, and changed by `tessera config set`.
#include "command/setup/config_file.h"
#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_config(std::string_view bytes) {
  const std::string text{bytes};
  const auto config = client::parse_config(text, "file");
  if (!config.ok())
    require(std::string(config.status().message()).starts_with("file:"), "an error without a place");
  // The text as a value, which is quoted as it has to be or refused.
  if (const auto changed = client::with_setting("# tls = \n[render]\n", "tls", text); changed.ok()) {
    const auto again = client::parse_config(*changed, "file");
    require(again.ok() && again->size() == 1 && again->front().key == "tls", "a value that is more than one");
  }
  if (!config.ok()) return false;
  // The value that was set is there, and is all that is new.
  if (const auto changed = client::with_setting(text, "render.spp", "64"); changed.ok()) {
    const auto again = client::parse_config(*changed, "file");
    require(again.ok() && again->size() <= config->size() + 1, "a setting that makes others");
  }
  for (const options::FileValue& value : client::values_for("render", *config))
    require(value.option.starts_with("--"), "an option that is none");
  return true;
}

}  // namespace

const Target kConfig = {"config", accepts_config};

}  // namespace tessera::fuzz
