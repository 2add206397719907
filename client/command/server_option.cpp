#include "command/server_option.h"

#include <iostream>
#include <utility>

#include "wire/channel.h"

namespace tessera::client {

void define_server_option(Command& command, ServerOption& option) {
  command.add("--server", option.address, "HOST:PORT of the coordinator")
      .from_environment("TESSERA_SERVER")
      .with_default();
  command.add("--tls", option.certificates, "folder with a client's certificates")
      .from_environment("TESSERA_TLS")
      .type_name("DIR");
  command.add_flag("--allow-insecure", option.allow_insecure, "talk without encryption to another machine");
}

absl::StatusOr<std::unique_ptr<FarmClient>> connect(const ServerOption& option, bool quiet) {
  auto channel = wire::make_channel(option.address,
                                    {.allow_insecure = option.allow_insecure, .certificates = option.certificates});
  if (!channel.ok()) return channel.status();
  FarmClientOptions options;
  options.address = option.address;
  if (!quiet) options.notice = [](const std::string& message) { std::cerr << "tessera: " << message << std::endl; };
  return std::make_unique<FarmClient>(*std::move(channel), std::move(options));
}

}  // namespace tessera::client
