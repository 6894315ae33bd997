/// What pickle and copy take of the results of queries.
#pragma once

#include "bullet_ccd/toi/toi.h"

#include "python/src/arrays.h"

#include <pybind11/pybind11.h>
#include <tuple>
#include <type_traits>

namespace bullet_ccd::python
{
template <class Value>
[[nodiscard]] py::object stateOf(const Value& value)
{
    if constexpr (std::is_same_v<Value, Eigen::Vector3d>)
    {
        return arrayOf(value);
    }
    else if constexpr (std::is_same_v<Value, ToiCounters>)
    {
        return py::make_tuple(value.nodePairs, value.trianglePairs, value.states);
    }
    else
    {
        return py::cast(value);
    }
}

template <class Value>
void restore(Value& value, const py::object& state)
{
    if constexpr (std::is_same_v<Value, Eigen::Vector3d>)
    {
        value = vectorOf(state, "state");
    }
    else if constexpr (std::is_same_v<Value, ToiCounters>)
    {
        const auto [nodes, triangles, states] =
            state.cast<std::tuple<std::int64_t, std::int64_t, std::int64_t>>();
        value = {.nodePairs = nodes, .trianglePairs = triangles, .states = states};
    }
    else
    {
        value = state.cast<Value>();
    }
}

/// For class_::def(): a state that consists of these members, which must be all that users see.
template <class Result, auto... members>
[[nodiscard]] auto pickled()
{
    return py::pickle([](const Result& result)
                      { return py::make_tuple(stateOf(result.*members)...); },
                      [](const py::tuple& state)
                      {
                          if (state.size() != sizeof...(members))
                          {
                              throw py::value_error("the state is that of another version");
                          }
                          Result result{};
                          std::size_t next = 0;
                          (restore(result.*members, py::object(state[next++])), ...);
                          return result;
                      });
}
}  // namespace bullet_ccd::python
