// The user's configuration file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "options/program.h"

namespace tessera::client {

/// One setting of the file: a key outside of all tables ("server", "tls", "allow-insecure"), or
/// "defaults.OPTION" and "COMMAND.OPTION".
struct ConfigValue {
  std::string key;
  std::string text;   // command-line form; elements of a list are joined by commas
  std::string place;  // "/home/anna/.config/tessera/config.toml:3"
};

/// $TESSERA_CONFIG, else tessera/config.toml in $XDG_CONFIG_HOME, else in ~/.config. Empty where there is no
/// home.
std::string config_path();

/// The settings of a file's text in the order of their keys. InvalidArgument, with `path` and line, for what
/// is no TOML, a table in a table, a key outside of tables that means nothing, or a value that is no text,
/// number, boolean or list of those.
absl::StatusOr<std::vector<ConfigValue>> parse_config(const std::string& text, const std::string& path);

/// The same of a file; none where there is no file. InvalidArgument for one of more than 1 MiB, too.
absl::StatusOr<std::vector<ConfigValue>> read_config(const std::string& path);

/// The options that the settings give a command: those of its own table, then those of [defaults] and the
/// keys outside of tables, which need not be options of it.
std::vector<options::FileValue> values_for(const std::string& command,
                                           const std::vector<ConfigValue>& config);

/// `text`, a file, with this setting changed or added; everything else, comments among it, stays.
/// InvalidArgument where the key cannot be one, or the result is no file that could be read.
absl::StatusOr<std::string> with_setting(const std::string& text, const std::string& key,
                                         const std::string& value);

}  // namespace tessera::client
