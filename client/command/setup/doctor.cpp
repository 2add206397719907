// tessera doctor: is everything as it has to be?
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/setup/config_file.h"
#include "command/setup/findings.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

struct DoctorOptions {
  ServerOption server;
  bool json = false;
};

constexpr const char* kWords[] = {"ok", "note", "fault"};

/// Settings of the file go into `server`, unless the command line or the environment said it: those are
/// seen by another value than the default.
std::vector<Finding> examine_config(ServerOption& server) {
  const std::string path = config_path();
  const absl::StatusOr<std::vector<ConfigValue>> config = read_config(path);
  if (!config.ok()) {
    return {{Health::kFault, "configuration", std::string{config.status().message()}, "mend the file"}};
  }
  for (const ConfigValue& value : *config) {
    if (value.key == "server" && server.address == ServerOption{}.address) server.address = value.text;
    if (value.key == "tls" && server.certificates.empty()) server.certificates = value.text;
    if (value.key == "allow-insecure" && value.text == "true") server.allow_insecure = true;
  }
  std::error_code error;
  return {{Health::kWell, "configuration",
           std::filesystem::exists(path, error) ? absl::StrCat(path, ", ", config->size(), " settings")
                                                : absl::StrCat("none (", path, ")"),
           ""}};
}

void print(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    std::cout << kWords[static_cast<int>(finding.health)] << '\t' << finding.subject << ": " << finding.text
              << '\n';
    if (!finding.advice.empty()) std::cout << "\t-> " << finding.advice << '\n';
  }
}

void print_json(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"health", kWords[static_cast<int>(finding.health)]},
                    {"subject", finding.subject},
                    {"text", finding.text},
                    {"advice", finding.advice}});
  }
  std::cout << list.dump(2) << '\n';
}

int run(DoctorOptions options, Interrupt& interrupt) {
  std::vector<Finding> findings{{Health::kWell, "version", wire::build_version(), ""}};
  const auto add = [&](const std::vector<Finding>& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  };
  add(examine_config(options.server));
  add(examine_machine());
  add(examine_certificates(options.server.certificates));
  add(examine_farm(options.server, interrupt.token()));
  options.json ? print_json(findings) : print(findings);
  const bool unwell =
      std::ranges::any_of(findings, [](const Finding& f) { return f.health == Health::kFault; });
  return unwell ? kUnwell : kDone;
}

}  // namespace

void add_doctor_command(CommandLine& line) {
  auto options = std::make_shared<DoctorOptions>();
  Command command = line.add_command("doctor", "Check this machine, the certificates and the coordinator");
  command.add_flag("--json", options->json, "as JSON");
  define_server_option(command, options->server);
  command.example("tessera doctor --server 10.0.0.1:7070 --tls ~/farm-tls/client-anna");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
