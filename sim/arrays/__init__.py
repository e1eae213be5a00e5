"""The reference model on arrays: many controllers and plants, one a lane, stepped at once.

There is one model, `heatwright.sim.reference`, written for one controller. It is run here as it
stands: its modules' syntax trees are translated so that each number may be an array with an
element for each lane. Where lanes part (an `if` that is true for some of them) both ways are gone,
each with a mask of the lanes it is for, and what is not masked stays as it was. Each operation on
an array is the IEEE 754 operation of its elements, in the order of the model: lanes and model are
equal bit for bit.

What cannot be translated fails, it is never guessed. Statements that the model is not written with
are refused at the translation; numpy refuses to take an array for one truth; and what lanes have in
common (the length of a list, the line of a host that is refused) raises an `AllLanesError` where it
would change for some of them. `world.step_logs` then does the lanes one by one.

    modules    the translated modules, imported by the name of the original
    translate  syntax tree -> syntax tree
    masks      what the translated code calls
    builtin    min, int, floor and so on, of arrays
    stack      N objects of the model -> one whose numbers are arrays
    plant      N thermal networks as one
    world      N controllers on N machines
"""
