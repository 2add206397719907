// tessera config show | get KEY | set KEY VALUE | path
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/setup/config_file.h"
#include "image/atomic_file.h"

namespace tessera::client {
namespace {

struct ConfigOptions {
  std::string action = "show", key, value;
};

/// The settings that hold now, and who says so.
struct Effective {
  std::string text, source;
};

/// Variables of the environment go before the file.
std::map<std::string, Effective> effective(const std::vector<ConfigValue>& config) {
  std::map<std::string, Effective> settings{{"server", {"127.0.0.1:7070", "default"}},
                                            {"tls", {"", "default: no encryption"}}};
  for (const ConfigValue& value : config) settings[value.key] = {value.text, value.place};
  for (const auto& [key, name] : {std::pair{"server", "TESSERA_SERVER"}, {"tls", "TESSERA_TLS"}}) {
    if (const char* const value = std::getenv(name); value != nullptr && *value != '\0')
      settings[key] = {value, absl::StrCat("$", name)};
  }
  return settings;
}

int show(const std::vector<ConfigValue>& config) {
  std::cout << "file: " << config_path() << '\n';
  for (const auto& [key, setting] : effective(config))
    std::cout << key << " = " << setting.text << "   (" << setting.source << ")\n";
  std::cout << "A command line goes before variables of the environment, and these before the file.\n";
  return kDone;
}

int get(const std::vector<ConfigValue>& config, const std::string& key) {
  const std::map<std::string, Effective> settings = effective(config);
  const auto found = settings.find(key);
  if (found == settings.end()) return report(kUsage, absl::StrCat("'", key, "' is not set"));
  std::cout << found->second.text << '\n';
  return kDone;
}

int set(const std::string& key, const std::string& value) {
  const std::string path = config_path();
  std::ifstream in(path);
  const std::string text{std::istreambuf_iterator<char>{in}, {}};
  const absl::StatusOr<std::string> changed = with_setting(text, key, value);
  if (!changed.ok()) return report(kUsage, std::string{changed.status().message()});
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  const absl::Status written = replace_file_with(path, *changed);
  return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
}

int run(const ConfigOptions& options) {
  if (config_path().empty()) return report(kUsage, "there is no home: set HOME, or TESSERA_CONFIG");
  if (options.action == "path") {
    std::cout << config_path() << '\n';
    return kDone;
  }
  if (options.action == "set") {
    if (options.key.empty()) return report(kUsage, "config set: expected KEY VALUE");
    return set(options.key, options.value);
  }
  const absl::StatusOr<std::vector<ConfigValue>> config = read_config(config_path());
  if (!config.ok()) return report(kUsage, std::string{config.status().message()});
  if (options.action == "show") return show(*config);
  if (options.key.empty()) return report(kUsage, "config get: expected KEY");
  return get(*config, options.key);
}

}  // namespace

void add_config_command(CommandLine& line) {
  auto options = std::make_shared<ConfigOptions>();
  Command command = line.add_command("config", "Show and change the configuration file");
  command.add("ACTION", options->action, "show, get, set or path (of the file)")
      .one_of({"show", "get", "set", "path"})
      .with_default();
  command.add("KEY", options->key, "server, tls, allow-insecure, defaults.OPTION or COMMAND.OPTION");
  command.add("VALUE", options->value, "of set");
  command.example("tessera config set server 10.0.0.1:7070");
  command.example("tessera config set render.spp 64");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
