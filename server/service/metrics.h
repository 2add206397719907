// Counts of the coordinator, for Prometheus.
#pragma once

#include <memory>

#include "service/farm/farm_news.h"

namespace prometheus {
class Collectable;
}  // namespace prometheus

namespace tessera::server {

class Connections;
class FarmViews;
class OpenStreams;

/// Counters and histograms, added to as things happen. Thread-safe.
class FarmMetrics final : public FarmObserver {
 public:
  FarmMetrics();
  ~FarmMetrics() override;

  void note(const FarmNews& news) override;
  std::shared_ptr<prometheus::Collectable> collectable() const;

 private:
  struct Series;
  std::unique_ptr<Series> series_;
};

/// Gauges of the farm's jobs, units and workers as they are when asked for. The farm must outlive them.
std::shared_ptr<prometheus::Collectable> farm_gauges(const FarmViews& views);
/// How many streams were cut off. They must outlive it.
std::shared_ptr<prometheus::Collectable> stream_counter(const OpenStreams& streams);
/// Connections that are open, were refused, or closed because nothing came on them. They must outlive it.
std::shared_ptr<prometheus::Collectable> connection_metrics(const Connections& connections);

}  // namespace tessera::server
