#include "wire/metrics.h"

#include <prometheus/exposer.h>

#include <exception>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::wire {

ReadFamily::ReadFamily(prometheus::MetricType type, const char* name, const char* help, const char* label)
    : label_(label) {
  family_.name = name;
  family_.help = help;
  family_.type = type;
}

prometheus::MetricFamily ReadFamily::family() && {
  for (const auto& [name, value] : values_) {
    prometheus::ClientMetric& metric = family_.metric.emplace_back();
    if (!name.empty()) metric.label = {{label_, name}};
    (family_.type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  }
  return std::move(family_);
}

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::start(
    const std::string& address, std::vector<std::shared_ptr<prometheus::Collectable>> sources) {
  std::unique_ptr<MetricsServer> server{new MetricsServer};
  server->sources_ = std::move(sources);
  try {
    server->exposer_ = std::make_unique<prometheus::Exposer>(address, /*num_threads=*/1);
  } catch (const std::exception& error) {
    return absl::UnavailableError(absl::StrCat("cannot serve metrics on ", address, ": ", error.what()));
  }
  for (const auto& source : server->sources_) server->exposer_->RegisterCollectable(source);
  return server;
}

MetricsServer::~MetricsServer() = default;

int MetricsServer::port() const { return exposer_->GetListeningPorts().front(); }

}  // namespace tessera::wire
