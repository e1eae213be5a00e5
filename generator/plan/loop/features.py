"""The features of a loop: the statements that each adds to the control step and to commands.

Features that add to the same stage run in the order of this file; docs/control.md describes that
order.
"""

from heatwright.generator.plan.loop.steps import Feature

SETTINGS = (
    Feature(
        begin="const bool {settings_sound} = settings_are_sound();"
        " /* if not, they are replaced, before one is used */",
        names={"settings_sound": "sound"},
        includes={"config.h": "{prefix}_*", "settings.h": "settings, settings_are_sound"},
    ),
    Feature(
        when=lambda loop: loop.on_limited,
        begin="const bool sound = guard_{name}_count_is_sound() && settings_sound;",
        names={"settings_sound": "settings_sound"},
    ),
    Feature(begin="loop_{name}.steps++;"),
    Feature(when=lambda loop: loop.types, begin="guard_{name}_keep_to_type();"),
    Feature(begin="loop_{name}.setpoint_c = settings.{name}_setpoint_c;"),
    Feature(
        when=lambda loop: loop.adjustable,
        begin="guard_{name}.maximum_c = settings.{name}_maximum_c;",
    ),
)
"""Features that act at the start of a step: they apply values that were set since the last step."""

SWITCHES = (
    Feature(
        when=lambda loop: loop.tunable,
        helpers=("mode",),
        begin="take_mode();",
        follow="next_mode = MODE_AUTOMATIC;\nloop_{name}.mode = MODE_AUTOMATIC;",
        set="next_mode = MODE_AUTOMATIC;",
        switch_off="next_mode = MODE_AUTOMATIC;",
    ),
    Feature(
        when=lambda loop: loop.switched,
        helpers=("switch",),
        begin="take_switch();",
        names={"starts": ""},
    ),
    Feature(when=lambda loop: loop.starts_enabled, names={"starts": " = ON"}),
    Feature(when=lambda loop: loop.must_release, helpers=("release",), disable="released = true;"),
    Feature(
        when=lambda loop: loop.commanded,
        helpers=("off",),
        names={"off": "loop_{name}.setpoint_c == 0.0f"},
    ),
    Feature(
        when=lambda loop: loop.tunable,
        names={"off": "loop_{name}.mode == MODE_AUTOMATIC && loop_{name}.setpoint_c == 0.0f"},
    ),
    Feature(when=lambda loop: loop.switched, names={"off": "!loop_{name}.enabled"}),
    Feature(
        when=lambda loop: loop.inputs,
        helpers=("idle",),
        includes={"gate.h": "gate_take_pause_{name}"},
        begin="loop_{name}.paused = gate_take_pause_{name}();",
        names={"idle": "loop_{name}.paused", "idle_words": ""},
    ),
    Feature(
        when=lambda loop: loop.commanded,
        names={"idle": "loop_{name}.paused || is_off()", "idle_words": "it is switched off, or "},
    ),
)
"""Features that act at the start of a step: they execute commands, on or off, and set the mode."""

READING = (
    Feature(
        read="loop_{name}.reading_status = sensor_{sensor}_take(&loop_{name}.reading_raw);",
        includes={"sensor_{sensor}.h": "sensor_{sensor}_take"},
        names={
            "celsius": "sensor_{sensor}_celsius(loop_{name}.reading_raw)",
            "judged_k": "now.change_k",
        },
    ),
    Feature(
        when=lambda loop: loop.also,
        helpers=("also",),
        includes={"monitor_{also}.h": "monitor_{also}, monitor_{also}_step"},
        read="read_{also}_too();",
    ),
    Feature(
        when=lambda loop: loop.averaged,
        helpers=("mean",),
        begin="const float reading_last_c = loop_{name}.reading_c;\n"
        "const bool had_reading = loop_{name}.has_reading;",
        names={"celsius": "mean_celsius()", "judged_k": "reading_change_k"},
    ),
    Feature(read="const struct reading now = convert_reading();"),
    Feature(
        when=lambda loop: loop.averaged,
        read="/* The protections use each single reading, not the mean. */\n"
        "const float reading_change_k ="
        " had_reading ? loop_{name}.reading_c - reading_last_c : 0.0f;",
    ),
)

PROGRAM = (
    Feature(
        when=lambda loop: loop.programmed,
        helpers=("program",),
        includes={"program.h": "program_step"},
        program="program_step(now.ok, sound);\nfollow_program();",
        refuse="program.state != PROGRAM_IDLE",
        disable="(void)program_stop(); /* also a start that waits for a reading */",
    ),
)

PROTECTIONS = (
    Feature(
        guard="fault_judge(sound, loop_{name}.temperature_c);",
        includes={"fault.h": "fault, fault_judge"},
    ),
    Feature(
        when=lambda loop: loop.relay_judged,
        guard="relay_judge(loop_{name}.temperature_c);",
        includes={"relay.h": "relay_judge"},
    ),
    Feature(
        each=lambda loop: loop.proven,
        guard="proof_{each}_judge(loop_{name}.temperature_c);",
        includes={"proof_{each}.h": "proof_{each}_judge"},
    ),
    Feature(
        when=lambda loop: loop.inputs_judged,
        guard="inputs_judge(loop_{name}.temperature_c);",
        includes={"inputs.h": "inputs_judge"},
    ),
    Feature(
        each=lambda loop: loop.monitors,
        guard="monitor_{each}_step();",
        includes={"monitor_{each}.h": "monitor_{each}_step"},
    ),
    Feature(when=lambda loop: loop.master_lost, guard="guard_{name}_master(!is_off());"),
    Feature(when=lambda loop: loop.on_limited, guard="guard_{name}_count(!is_off());"),
    Feature(
        when=lambda loop: loop.current,
        guard="current_{heater}_step();",
        includes={"current_{heater}.h": "current_{heater}_step"},
    ),
    Feature(
        includes={"guard_{name}.h": "guard_{name}_step"},
        guard="const uint8_t verdict = guard_{name}_step({judged_k}, now.gap);",
    ),
)

SELF_CHECKS = (
    Feature(
        when=lambda loop: loop.checked,
        helpers=("checked",),
        read="mark(READ);",
        guard="mark(verdict & GUARD_JUDGED);",
    ),
)

DUTY = (
    Feature(
        when=lambda loop: loop.limits_adjustable,
        helpers=("limits",),
        start="take_limits();",
        decide="take_limits(); "
        "/* after the guard, which judges the last duty by the limits that it had */",
    ),
    Feature(names={"heats": "algorithm_{name}_step", "decides": "algorithm_{name}_step"}),
    Feature(
        when=lambda loop: loop.autotune,
        helpers=("tuning",),
        includes={"autotune_{name}.h": "autotune_{name}_step"},
        begin="const float last_c = loop_{name}.temperature_c;",
        decide="run_experiment(now.ok, last_c);",
        refuse="next_mode == MODE_TUNING && setpoint_c != settings.{name}_setpoint_c",
        names={"heats": "tune_or_control"},
    ),
    Feature(
        when=lambda loop: loop.can_idle,
        helpers=("heat_unless_idle",),
        names={"decides": "heat_unless_idle"},
    ),
    Feature(
        includes={"algorithm_{name}.h": "algorithm_{name}_step"}, decide="decide(now, verdict);"
    ),
    Feature(when=lambda loop: loop.limited, helpers=("current",), limit="limit_duty();"),
)

OUTPUTS = (
    Feature(
        when=lambda loop: loop.cooler,
        helpers=("cooler",),
        includes={"output_{cooler}.h": "output_{cooler}_set"},
        drive="loop_{name}.cooling = cool(now.ok);\n"
        "output_{cooler}_set(loop_{name}.cooling ? 100.0f : 0.0f);",
    ),
    Feature(
        when=lambda loop: loop.heater_holds,
        helpers=("holding",),
        drive="stop_holding(now.ok);",
        names={"or_idle": ""},
    ),
    Feature(
        when=lambda loop: loop.hosted or loop.programmed or loop.inputs,
        names={"or_idle": " || {idle_call}"},
    ),
    Feature(
        drive="output_{heater}_set(loop_{name}.duty_percent);",
        includes={"output_{heater}.h": "output_{heater}_set"},
    ),
    Feature(when=lambda loop: loop.wants_relay, drive="gate_want_{name}(!is_off());"),
    Feature(includes={"gate.h": "gate_renew_{name}"}),
    Feature(when=lambda loop: loop.checked, drive="renew_if_in_order();"),
    Feature(when=lambda loop: not loop.checked, drive="gate_renew_{name}();"),
)

REPORTS = (
    Feature(start="sensor_{sensor}_begin();", tick="sensor_{sensor}_begin();"),
    Feature(when=lambda loop: loop.programmed, report="program_count(loop_{name}.duty_percent);"),
    Feature(
        when=lambda loop: loop.response,
        includes={"response_{name}.h": "response_{name}_step"},
        report="response_{name}_step(fault.code == FAULT_NONE{and_held}, now.ok);",
        names={"and_held": ""},
    ),
    Feature(when=lambda loop: loop.can_idle, names={"and_held": " && !{idle_call}"}),
    Feature(
        when=lambda loop: loop.tunable,
        names={"and_held": " && !{idle_call} && loop_{name}.mode == MODE_AUTOMATIC"},
    ),
    Feature(
        when=lambda loop: loop.plotted,
        includes={"plotter.h": "plotter_send"},
        tick="plotter_send();",
    ),
    Feature(
        when=lambda loop: loop.countdown,
        includes={"countdown.h": "countdown_step"},
        tick="countdown_step();",
    ),
    Feature(
        when=lambda loop: loop.keyed, includes={"panel.h": "panel_refresh"}, tick="panel_refresh();"
    ),
    Feature(when=lambda loop: loop.has_state, public=("state",), names={"and_on": ""}),
    Feature(when=lambda loop: loop.commanded, names={"and_on": " && !is_off()"}),
)

COMMANDS = (
    Feature(
        when=lambda loop: loop.switched,
        public=("switched",),
        names={"highest": "{prefix}_SETPOINT_MAXIMUM_C", "and_may_enable": ""},
    ),
    Feature(
        when=lambda loop: loop.types,
        public=("types",),
        names={"highest": "loop_{name}_highest_c()"},
    ),
    Feature(
        when=lambda loop: loop.programmed,
        names={"and_may_enable": " && program.state == PROGRAM_IDLE"},
    ),
    Feature(
        when=lambda loop: loop.must_release,
        names={"and_may_enable": " && (released || next_enabled == ON)"},
    ),
    Feature(when=lambda loop: loop.hosted, public=("hosted",)),
    Feature(
        when=lambda loop: loop.hosted and loop.keyed,
        public=("hosted_keys",),
        names={"by_hand_or": ""},
    ),
    Feature(
        when=lambda loop: loop.tunable, names={"by_hand_or": "next_mode != MODE_AUTOMATIC || "}
    ),
    Feature(
        when=lambda loop: loop.commanded, public=("regulates",), names={"regulates": "!{idle_call}"}
    ),
    Feature(
        when=lambda loop: loop.tunable,
        names={"regulates": "loop_{name}.mode != MODE_MANUAL && !{idle_call}"},
    ),
    Feature(when=lambda loop: loop.hosted, public=("ready",)),
    Feature(when=lambda loop: loop.switched and loop.tunable, public=("switched_mode",)),
    Feature(when=lambda loop: loop.hosted and loop.tunable, public=("hosted_mode",)),
    Feature(when=lambda loop: loop.autotune, public=("tuning",)),
    Feature(when=lambda loop: loop.lasting, public=("lasting",)),
)
"""Commands of a host, a master or a person."""

FEATURES = (
    *SETTINGS, *SWITCHES, *READING, *PROGRAM, *PROTECTIONS, *SELF_CHECKS, *DUTY,
    *OUTPUTS, *REPORTS, *COMMANDS,
)  # fmt: skip
