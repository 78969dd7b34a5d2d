// The time of a call: until when it may take, and what it costs.
#pragma once

#include <chrono>

namespace halfshade {

// No deadline: 30 s from now; one that is further than 10 min: cut to that.
std::chrono::system_clock::time_point EffectiveDeadline(std::chrono::system_clock::time_point asked);

// CPU time of the whole process, milliseconds. With one call at a time its difference is the call's, GL driver threads
// included; calls on other contexts at the same time are counted in.
double ProcessCpuMs();

}  // namespace halfshade
