"""The controller of these tests: a loop with gains and one with a measured current."""

SLAVE = """
heatwright: 1
controller: {name: shape, title: 'Shape "of" 50 °C', board: mega2560}
sensors:
  air: {kind: thermistor, pin: A1, divider: {pull_up: 4.7 kΩ}, oversample: 4,
    curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: -20 °C .. 300 °C}
  bed: {kind: thermistor, pin: A3, divider: {pull_up: 4.7 kΩ}, oversample: 4,
    curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: -20 °C .. 300 °C}
  shunt: {kind: current, pin: A4, scale: 0.2 V/A}
outputs:
  heater: {kind: pwm, pin: D46, frequency: 100 Hz, power: 40 W}
  hot_bed: {kind: digital, pin: D22, power: 100 W, supply: 24 V,
    current: {sensor: shunt, trip: 6 A}}
loops:
  air:
    sensor: air
    heater: heater
    period: 500 ms
    algorithm: {kind: pid, kp: 8, ki: 0.05, kd: 30, derivative_filter: 4 s,
      integral: {maximum: 60 %}}
    autotune: {}
    setpoint: {initial: 20 °C, minimum: -5 °C, maximum: 250 °C}
    protection: {maximum: 280 °C, minimum: -10 °C, rise_rate: 20 K/s, frozen: off}
  bed:
    sensor: bed
    heater: hot_bed
    period: 1 s
    algorithm: {kind: on_off, hysteresis: 1 K}
    setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}
    protection: {maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s, frozen: off}
interfaces:
  - {kind: modbus_rtu, address: 17, baud: 1200, parity: odd, driver_enable: D37}
"""
ADDRESS = 17
