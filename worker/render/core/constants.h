#pragma once

namespace tessera::render {

inline constexpr float kPi = 3.14159265358979f;
inline constexpr float kInvPi = 0.31830988618379f;
inline constexpr float kInv2Pi = 0.15915494309190f;
inline constexpr float kInv4Pi = 0.07957747154595f;
/// Largest float below 1.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

}  // namespace tessera::render
