// Metrics of a worker, for Prometheus.
#pragma once

#include <memory>

namespace prometheus {
class Collectable;
}

namespace tessera::agent {

class Agent;

/// The agent's report, as it is when asked for. The agent must outlive it.
std::shared_ptr<prometheus::Collectable> agent_metrics(const Agent& agent);

}  // namespace tessera::agent
