#include "command/server_option.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <utility>

#include "wire/channel.h"

namespace tessera::client {

void define_server_option(CLI::App& command, ServerOption& option) {
  command.add_option("--server", option.address, "HOST:PORT of the coordinator")
      ->envname("TESSERA_SERVER")
      ->capture_default_str();
  command.add_flag("--allow-insecure", option.allow_insecure, "talk without encryption to another machine");
}

absl::StatusOr<std::unique_ptr<FarmClient>> connect(const ServerOption& option, bool quiet) {
  auto channel = wire::make_channel(option.address, {.allow_insecure = option.allow_insecure});
  if (!channel.ok()) return channel.status();
  FarmClientOptions options;
  options.address = option.address;
  if (!quiet) options.notice = [](const std::string& message) { std::cerr << "tessera: " << message << std::endl; };
  return std::make_unique<FarmClient>(*std::move(channel), std::move(options));
}

}  // namespace tessera::client
