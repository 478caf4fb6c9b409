"""A cart with a pole: its linear model from the push to the angle, and a sampled PID controller that balances it.

Prints::

    the pole falls as exp(4.352022 t), by the equations of a cart-pole exp(4.352022 t)
    at 20 rad/s: 3.545014e-03 rad/N, by the equations 3.545014e-03
    after 5 s the angle is 3.5e-04 rad; the push reached 12.0 N
    certificate passed: True
"""

import numpy as np

from mbsd3d import GROUND, Body, Force, Input, Prismatic, Revolute, Stepper, System, measures, state_space

CART, POLE, HALF, G = 1.0, 0.3, 0.5, 9.81  # kg, kg, m to the centre of mass of the pole, m/s^2
KP, KI, KD, EVERY = 60.0, 40.0, 12.0, 0.005  # N/rad, N/(rad s), N s/rad, s between samples

cart = Body("cart", CART, (0.1, 0.1, 0.1))
pole = Body("pole", POLE, (0.02, 0.02, 0.001), com=(0, 0, HALF))
rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
push = Input("push")
stand = System([cart, pole], [rail, pin], [Force(cart, (push, 0, 0))], name="stand")

linear = state_space(stand, stand.state(), inputs=[push], outputs=[measures.angle(pin)])
total, moment = CART + POLE, 0.02 + POLE * HALF**2
fall = np.sqrt(total * POLE * G * HALF / (total * moment - (POLE * HALF) ** 2))
print(f"the pole falls as exp({max(linear.poles.real):.6f} t), by the equations of a cart-pole exp({fall:.6f} t)")

w = np.array([20.0])
gain = linear.frequency_response(w).H[0, 0, 0]
exact = POLE * HALF / ((total * moment - (POLE * HALF) ** 2) * (w[0] ** 2 + fall**2))
print(f"at 20 rad/s: {gain.real:.6e} rad/N, by the equations {exact:.6e}")

run = Stepper(stand, stand.assemble(angles={pin: 0.2}), measures=[measures.angle(pin), measures.rate(pin)])
integral = largest = 0.0
for k in range(1000):
    angle, rate = run.measured
    integral += EVERY * angle
    force = float(KP * angle + KI * integral + KD * rate)
    largest = max(largest, abs(force))
    run.set("push", force)
    run.advance((k + 1) * EVERY)
solution = run.solution()
print(f"after 5 s the angle is {abs(solution.angle(pin)[-1]):.1e} rad; the push reached {largest:.1f} N")
print("certificate passed:", solution.certificate.passed)
figure = solution.plot([("angle", pin), ("slide", rail)])
